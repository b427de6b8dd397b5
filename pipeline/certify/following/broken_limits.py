"""The least errors of actuators at which a sampled pose breaks a limit, for comparison with what is proven.

To first order each limit is lost fastest in one corner of the errors, the signs of its gradient. The most critical
poses are followed there until a limit breaks.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.limits import ErrorProvenLimit
from pipeline.machine.kinematics import newton
from pipeline.machine.samples import PoseSamples
from pipeline.refine.result import Path

_SAMPLES, _CANDIDATES = 401, 24
_PROBE_M = 1e-6
_FACTORS = np.arange(0.1, 3.0, 0.025)
"""Errors that are tried, as parts of what breaks a limit to first order."""


@dataclass(frozen=True)
class Broken:
    """Errors of the largest actuator at which a limit is broken, and where; infinite if none was seen."""

    eps_m: float
    s: float


def breaking_errors(limits: Sequence[ErrorProvenLimit], path: Path, weights: FloatArray) -> Broken:
    """Find the least errors, in the ratio of `weights` (5,), at which a sampled pose breaks a limit."""
    s = np.linspace(0.0, 1.0, _SAMPLES)
    pose, q = path.pose(s), path.q(s)
    margins = _margins(limits, PoseSamples(path.machine, pose, q))
    slopes = np.zeros((*margins.shape, 5))
    for k in np.flatnonzero(weights):
        moved = q + _PROBE_M * np.eye(5)[k]
        found, _ = newton(path.machine, moved, pose)
        slopes[..., k] = (_margins(limits, PoseSamples(path.machine, found, moved)) - margins) / _PROBE_M
    with np.errstate(divide="ignore", invalid="ignore"):
        lost_at = np.maximum(margins, 0.0) / (np.abs(slopes) @ weights)
    rows, columns = np.unravel_index(np.argsort(lost_at, axis=None)[:_CANDIDATES], lost_at.shape)
    finite = np.isfinite(lost_at[rows, columns])
    if not finite.any():
        return Broken(np.inf, float(s[np.argmin(margins.min(axis=1))]))
    rows, columns = rows[finite], columns[finite]
    first, signs = lost_at[rows, columns], -np.sign(slopes[rows, columns]) * weights
    return _followed(limits, (path, s[rows]), first, signs)


def _followed(
    limits: Sequence[ErrorProvenLimit], where: tuple[Path, FloatArray], first_m: FloatArray, signs: FloatArray
) -> Broken:
    """Follow poses at s (n,) in their corners (n, 5) until a limit breaks."""
    path, s = where
    pose, q, least = path.pose(s), path.q(s), Broken(np.inf, float(s[0]))
    for factor in _FACTORS:
        off = q + (factor * first_m)[:, None] * signs
        pose, _ = newton(path.machine, off, pose)
        broken = (_margins(limits, PoseSamples(path.machine, pose, off)) < 0.0).any(axis=1)
        for row in np.flatnonzero(broken & (factor * first_m < least.eps_m)):
            least = min(least, Broken(float(factor * first_m[row]), float(s[row])), key=lambda one: one.eps_m)
        if (factor * first_m >= least.eps_m).all():
            break
    return least


def _margins(limits: Sequence[ErrorProvenLimit], samples: PoseSamples) -> FloatArray:
    return np.concatenate([limit.margins(samples) for limit in limits], axis=1)
