"""What stage two minimises: one row per value of `refine.objective`.

| objective | minimised | then lowered by the sequential programs |
|---|---|---|
| integral | I | I / L + max(0, K - min(0.97 K_c, 1.1 K_r)), with K <= K_c |
| mixed | I / L + K | I / L + K |
| maximum | K | 0.01 I / L + K |
| time | as integral, then T / T_ref + w I / I_ref from its path (`timed.minimise`) | as integral |

I is the integral of kappa over the length in the metric of the route, L the length of the coarse path, K the largest
kappa, K_c that of the coarse path, and K_r the least one with which regions join start and goal. What is not smooth
counts as part of I. K counts down to kappa at the start and the goal, which are given.
"""

from collections.abc import Callable
from dataclasses import dataclass

from pipeline.refine.measure import KappaFigures

TIE_BREAK = 0.01
"""Weight of the mean of kappa where only the largest one counts: it settles what the largest leaves open."""


@dataclass(frozen=True)
class Objective:
    """What is minimised, and how.

    Attributes
    ----------
    mean_weight, peak_weight : float
        Weights of I / L and of K above its target in the sequential programs.
    improves_on_coarse : bool
        Whether K must not exceed K_c and counts only above a share of it.
    starts_with_ipopt : bool
        Whether IPOPT minimises the integral of kappa first.
    minimised : callable
        Reduces the figures of a path, given L, to the value whose relative change ends the refinement of the mesh.
    timed : bool
        Whether path and time law are found together afterwards.
    """

    mean_weight: float
    peak_weight: float
    improves_on_coarse: bool
    starts_with_ipopt: bool
    minimised: Callable[[KappaFigures, float], float]
    timed: bool = False


OBJECTIVES: dict[str, Objective] = {
    "integral": Objective(
        mean_weight=1.0,
        peak_weight=1.0,
        improves_on_coarse=True,
        starts_with_ipopt=True,
        minimised=lambda figures, length: figures.kappa_integral,
    ),
    "mixed": Objective(
        mean_weight=1.0,
        peak_weight=1.0,
        improves_on_coarse=False,
        starts_with_ipopt=True,
        minimised=lambda figures, length: figures.kappa_integral / length + figures.kappa_max,
    ),
    "maximum": Objective(
        mean_weight=TIE_BREAK,
        peak_weight=1.0,
        improves_on_coarse=False,
        starts_with_ipopt=False,
        minimised=lambda figures, length: figures.kappa_max,
    ),
    "time": Objective(
        mean_weight=1.0,
        peak_weight=1.0,
        improves_on_coarse=True,
        starts_with_ipopt=True,
        minimised=lambda figures, length: figures.kappa_integral,
        timed=True,
    ),
}
"""All objectives, by their value of `refine.objective`."""
