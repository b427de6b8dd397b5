"""Whether a simulated motion stays within the proven tube about its path: contour errors, not lags.

That all actuators are late together is no error: what counts is how far they are, at a time, off some point q(u) of the
motion, and u may be any continuous function of time. Here u is linear between two periods, and at each the one with
the least share max |q_k - q_k(u)| / A_k nearby. Both motions are taken as linear between two rows; what they deviate
from that by, at most (h^2 / 8) max |qdd| for each, is added.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.simulate.motion import Motion
from pipeline.simulate.result import Simulation

if TYPE_CHECKING:
    from pipeline.certify.recheck.tube import ProvenTube

_FARTHEST_S = 0.15
"""How far u is looked for from the time itself, either way."""
_STRIDE_S = 2e-3
"""How far apart the points are that are compared first."""
_SECTIONS = 25
_GOLDEN = (5.0**0.5 - 1.0) / 2.0
_BLOCK = 500
"""Rows that are compared at a time."""


@dataclass(frozen=True, eq=False)
class TubeCheck:
    """How far a simulated motion of n rows is off its path, against what is proven.

    Attributes
    ----------
    tube : ProvenTube
        What is proven.
    late_s : (n,)
        How late each row is against the point of the motion that it is compared with: t - u.
    contour_error_m : (n, 5)
        q(u) - q, in the order of the actuators.
    share : (n,)
        The largest part of the tube that an actuator takes until the next row: above 1 where it may be outside.
    """

    tube: "ProvenTube"
    late_s: FloatArray
    contour_error_m: FloatArray
    share: FloatArray

    @property
    def inside(self) -> bool:
        """Whether the whole motion is within the tube."""
        return bool((self.share <= 1.0).all())

    @property
    def worst(self) -> int:
        """The row with the largest share."""
        return int(self.share.argmax())


def check_tube(simulation: Simulation, tube: "ProvenTube") -> TubeCheck:
    """Compare a simulated motion with the proven tube about its path."""
    motion, n, period = simulation.motion, len(simulation), simulation.motion.period_s
    real, rows = simulation.q_m, np.arange(n)
    blocks = [rows[first : first + _BLOCK] for first in range(0, n, _BLOCK)]
    u = np.concatenate([_nearest(motion, real[block], block, tube.errors_m) for block in blocks])
    error = _along(motion.q_m, u) - real
    off = np.abs(error)
    to_next = np.maximum(off, np.vstack([off[1:], off[-1:]]))
    steps_s = period * np.abs(np.diff(u, append=u[-1:]))[:, None]
    commanded, driven = (np.abs(qdd).max(axis=0) for qdd in (motion.qdd_mps2, simulation.qdd_mps2))
    bend = ((period**2 + steps_s**2) * commanded + period**2 * driven) / 8.0
    return TubeCheck(tube, period * (rows - u), error, ((to_next + bend) / tube.errors_m).max(axis=1))


def _nearest(motion: Motion, real_m: FloatArray, rows: IntArray, errors_m: FloatArray) -> FloatArray:
    """Find for positions (n, 5) at rows (n,) the row of the motion, with a fraction, that is nearest to each."""
    stride = max(1, round(_STRIDE_S / motion.period_s))
    reach = stride * round(_FARTHEST_S / _STRIDE_S)
    last = len(motion) - 1.0
    around = (rows[:, None] + np.arange(-reach, reach + 1, stride)).clip(0, last).astype(int)
    shares = (np.abs(motion.q_m[around] - real_m[:, None]) / errors_m).max(axis=2)
    best = around[np.arange(len(rows)), shares.argmin(axis=1)]

    def share(u: FloatArray) -> FloatArray:
        shares: FloatArray = (np.abs(_along(motion.q_m, u) - real_m) / errors_m).max(axis=1)
        return shares

    # Golden section: the share is nearly convex between neighbours, and any u is as good for the proof.
    low, high = (best - stride).clip(0.0), (best + stride).clip(max=last)
    for _ in range(_SECTIONS):
        first, second = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        left = share(first) <= share(second)
        low, high = np.where(left, low, first), np.where(left, second, high)
    middle = (low + high) / 2.0
    return np.asarray(np.where(share(middle) <= share(best.astype(float)), middle, best))


def _along(q_m: FloatArray, u: FloatArray) -> FloatArray:
    """Interpolate rows (m, 5) linearly at rows with a fraction (n,)."""
    row = np.floor(u).astype(int).clip(0, len(q_m) - 2)
    part = (u - row)[:, None]
    return np.asarray((1.0 - part) * q_m[row] + part * q_m[row + 1])
