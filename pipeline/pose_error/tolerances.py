"""Which errors of the drives a wanted accuracy of the tool asks for: the inverse of the proven bound."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty
from pipeline.machine.geometry import ACTUATORS
from pipeline.progress import QUIET, Monitor

COMMON, EQUAL_SHARES = "all alike", "equal shares"
_ENOUGH = 0.99
"""Share of the accuracy that is used up at least, where the proof allows."""
_AIM = 0.997
_TRIALS = 6
Bound = Callable[[Uncertainty], float]
"""Bounds the tool's error in metres."""


@dataclass(frozen=True, eq=False)
class DriveTolerance:
    """Errors of the drives, (5,), for which the tool is proven to be as accurate as wanted, and that bound."""

    errors_m: FloatArray
    bound_m: float


def find_drive_tolerances(
    bound: Bound, amplification: FloatArray, geometry: Uncertainty, accuracy_m: float, monitor: Monitor = QUIET
) -> dict[str, DriveTolerance]:
    """Find how far drives may be off if the tool is to be within `accuracy_m` all along a path.

    All alike; each with an equal share of the error, so in the inverse ratio of their amplifications; and each alone.

    Parameters
    ----------
    bound : callable
        Gives the largest proven error of the tool in metres for an uncertainty; raises a NoSolutionError if none is.
    amplification : (5,)
        The largest |dp / dq_k| of each drive.
    geometry : Uncertainty
        Errors of the geometry, which the tool bears beside.

    Raises
    ------
    NoSolutionError
        If errors of the geometry alone take all of the accuracy, or nothing is proven.
    """
    taken = bound(replace(geometry, actuator_m=CERTAIN.actuator_m)) if geometry.calibration else 0.0
    if taken >= accuracy_m:
        raise NoSolutionError(
            "pose error",
            f"errors of the geometry alone put the tool up to {1e3 * taken:.4g} mm off, more than the "
            f"{1e3 * accuracy_m:.4g} mm that are wanted",
            "Ask for less (--accuracy-mm), or know the geometry better (--lengths-mm, --coordinates-mm).",
            {"geometry_m": taken},
        )
    kinds = {COMMON: np.ones(len(ACTUATORS)), EQUAL_SHARES: amplification.min() / amplification}
    kinds |= dict(zip(ACTUATORS, np.eye(len(ACTUATORS)), strict=True))
    found = {}
    for name, weights in kinds.items():
        monitor.progress(f"{name} alone" if name in ACTUATORS else f"drives: {name}")
        first = _AIM * (accuracy_m - taken) / float((amplification * weights).sum())
        eps, proven = _largest(_scaled(bound, geometry, weights), accuracy_m, taken, first)
        found[name] = DriveTolerance(eps * weights, proven)
    return found


def _scaled(bound: Bound, geometry: Uncertainty, weights: FloatArray) -> Callable[[float], float]:
    return lambda eps: bound(replace(geometry, actuator_m=tuple((eps * weights).tolist())))


def _largest(bound: Callable[[float], float], accuracy_m: float, taken: float, first: float) -> tuple[float, float]:
    """Find the largest error for which the bound is within the accuracy, and that bound, by secants.

    The bound is nearly linear, from `taken` without errors of drives on; the first error that is tried is `first`.
    """
    best, failed, refusal, eps = (0.0, taken), np.inf, None, first
    for _ in range(_TRIALS):
        try:
            found = bound(eps)
        except NoSolutionError as error:
            failed, refusal, eps = eps, error, (eps + best[0]) / 2.0
            continue
        if best[0] < eps and found <= accuracy_m:
            best = eps, found
        if _ENOUGH * accuracy_m <= found <= accuracy_m:
            break
        eps *= _AIM * (accuracy_m - taken) / (found - taken)
        eps = eps if eps < failed else (failed + best[0]) / 2.0
    if best[0] == 0.0:
        raise refusal or NoSolutionError(
            "pose error",
            f"no error of the drives is proven to keep the tool within {1e3 * accuracy_m:.4g} mm",
            "Ask for less (--accuracy-mm).",
        )
    return best
