"""The machines that a calibration leaves possible: theta = W u with |u| <= k.

theta are deviations from the machine of a run: joints on the platform a_l, joints on carts b_l, y and z of rails, fixed
lengths, and zeros z and scales s of the five actuators. Where the machine of the run has an actuator at q, its encoder
shows n = (q - q0) / s0 from the middle of its range, so that the actuator of another machine is at q + dz + n ds there:
all that theta changes of a machine at q is linear in it.
"""

from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np
from flint import arb_mat

from pipeline.arrays import FloatArray
from pipeline.inclusion.matrices import ball_matrix
from pipeline.machine.geometry import ACTUATORS, ARM_OF_LINK, TELESCOPES

_LINKS, _ARMS = 6, 3
PLATFORM, OFFSETS, RAILS, LENGTHS, ZEROS, SCALES = (
    slice(0, 18),
    slice(18, 36),
    slice(36, 42),
    slice(42, 46),
    slice(46, 51),
    slice(51, 56),
)
PARAMETERS = SCALES.stop
"""How many parameters a machine has: the rows of W, in this order."""
FIXED = tuple(link for link in range(_LINKS) if link not in TELESCOPES)
"""Links of fixed length."""


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """Machines {W u, |u| <= k} about that of a run.

    Attributes
    ----------
    factor : (56, m)
        W: W W' is the covariance of the parameters.
    sigma : float
        k: standard deviations of every linear combination of parameters.
    zero_at_m, scale : (5,)
        q0 and s0 of the actuators.

    Raises
    ------
    ValueError
        If the arrays have other shapes, or numbers that are not finite, or k is not positive, or a scale is not.
    """

    factor: FloatArray
    sigma: float
    zero_at_m: FloatArray
    scale: FloatArray

    def __post_init__(self) -> None:
        if self.factor.ndim != 2 or len(self.factor) != PARAMETERS or not self.factor.shape[1]:
            raise ValueError(f"an ellipsoid has a factor of {PARAMETERS} rows, not of shape {self.factor.shape}")
        if not self.zero_at_m.shape == self.scale.shape == (len(ACTUATORS),):
            raise ValueError(f"an ellipsoid has zeros and scales of {len(ACTUATORS)} actuators")
        numbers = np.concatenate([self.factor.ravel(), self.zero_at_m, self.scale])
        if not (np.isfinite(numbers).all() and 0.0 < self.sigma < inf and (self.scale > 0.0).all()):
            raise ValueError("an ellipsoid has finite numbers, and k and scales above zero")

    @cached_property
    def rows(self) -> "FactorRows":
        """The rows of W in balls."""
        return factor_rows(self)


@dataclass(frozen=True, eq=False)
class FactorRows:
    """The rows of W by what they change.

    Attributes
    ----------
    points, anchors : 6 matrices 3 x m
        da_l; and of cart joints, with rails, but without the cart's own position.
    lengths : 6 matrices 1 x m, None for telescopes
        Fixed lengths.
    rails : 3 matrices 3 x m
        (0, y, z) of rails.
    zeros, scales : 5 matrices 1 x m
        Of the actuators.
    """

    points: list[arb_mat]
    anchors: list[arb_mat]
    lengths: list[arb_mat | None]
    rails: list[arb_mat]
    zeros: list[arb_mat]
    scales: list[arb_mat]


def factor_rows(ellipsoid: Ellipsoid) -> FactorRows:
    """Sort the rows of W."""
    W = ellipsoid.factor
    points, offsets = (W[part].reshape(_LINKS, 3, -1) for part in (PLATFORM, OFFSETS))
    across = W[RAILS].reshape(_ARMS, 2, -1)
    rails = [ball_matrix(np.vstack([np.zeros((1, W.shape[1])), each])) for each in across]
    fixed = iter(W[LENGTHS])
    return FactorRows(
        points=[ball_matrix(each) for each in points],
        anchors=[ball_matrix(each) + rails[arm] for each, arm in zip(offsets, ARM_OF_LINK.tolist(), strict=True)],
        lengths=[ball_matrix(next(fixed)[None]) if link in FIXED else None for link in range(_LINKS)],
        rails=rails,
        zeros=[ball_matrix(row[None]) for row in W[ZEROS]],
        scales=[ball_matrix(row[None]) for row in W[SCALES]],
    )
