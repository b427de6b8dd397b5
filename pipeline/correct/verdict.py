"""A corrected motion against one that is planned again for the same machine: which is better, by what was measured."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from pipeline.arrays import FloatArray

CORRECT, PLAN_AGAIN = "correct", "plan again"
_CERTIFIED = "certified"


@dataclass(frozen=True)
class Motion:
    """What is known of a motion of the calibrated machine.

    Attributes
    ----------
    certified : bool
        The path is proven to be free of singularities and within its limits.
    left_m : float
        How far the TCP is at most from where the motion is to have it: zero for one that is planned for this machine.
    away_m : float
        How far the TCP is at most from the way that was planned first.
    kappa_max, kappa_bound : float, float or None
        Its largest kappa, and what it is proven not to exceed.
    duration_s : float
        How long it takes.
    """

    certified: bool
    left_m: float
    away_m: float
    kappa_max: float
    kappa_bound: float | None
    duration_s: float


@dataclass(frozen=True)
class Verdict:
    """Which motion is better, `correct` or `plan again`, and why."""

    better: str
    reasons: tuple[str, ...]


def measure_motion(summary: Mapping[str, Any], left_m: float, away_m: float) -> Motion:
    """Read what the summary of a run says of its motion."""
    certificate = summary["certificate"]
    return Motion(
        certified=certificate.get("verdict") == _CERTIFIED,
        left_m=left_m,
        away_m=away_m,
        kappa_max=summary["path"]["kappa_max"],
        kappa_bound=certificate.get("kappa_bound"),
        duration_s=summary["trajectory"]["duration_s"],
    )


def largest_distance(places_m: FloatArray, way_m: FloatArray) -> float:
    """How far some of these places (n, 3) is at most from the nearest of a way (m, 3)."""
    return float(np.max(KDTree(way_m).query(places_m)[0]))


def judge(corrected: Motion | None, again: Motion | None) -> Verdict:
    """Judge which is better: a motion that is proven, then one that is off by less; None: there is no such motion."""
    if corrected is None or again is None:
        better, missing = (PLAN_AGAIN, "corrected") if corrected is None else (CORRECT, "planned again")
        return Verdict(better, (f"there is no {missing} motion",))
    if corrected.certified != again.certified:
        return Verdict(CORRECT if corrected.certified else PLAN_AGAIN, ("the other one is not certified",))
    better = PLAN_AGAIN if again.left_m < corrected.left_m else CORRECT
    left, away = ([1e3 * getattr(one, key) for one in (again, corrected)] for key in ("left_m", "away_m"))
    return Verdict(
        better,
        (
            f"planned again it leaves {left[0]:.3f} mm at the TCP, corrected {left[1]:.3f} mm",
            f"planned again it takes {again.duration_s:.3f} s, corrected {corrected.duration_s:.3f} s",
            f"planned again the TCP is up to {away[0]:.1f} mm away from the way that was planned first, corrected "
            f"{away[1]:.3f} mm: take the corrected one where that way matters",
        ),
    )
