"""Cores without what no route can pass, where travel along X costs; and the routes that are found on the way."""

from dataclasses import replace

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.bounds.shortest_paths import Bounds
from pipeline.route.core.build import Core
from pipeline.route.core.pruning import prune
from pipeline.route.metric import ROUNDING
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.solution import StepSequence
from pipeline.route.programs.travel_program import Tangents
from pipeline.route.search.outer_approximation import with_best_x
from pipeline.route.search.x_positions import cheapest_x
from pipeline.solvers.highs import Outcome
from pipeline.status import Status

_ROUNDS = 3
"""Prunings of a core, each at the cost of the best route of the one before."""


def tighten_core(
    problem: RouteProblem, core: Core, bounds: Bounds, tangents: Tangents, known_cost: float
) -> tuple[Core, StepSequence | None]:
    """Leave out of a core that is not empty what no route of at most its threshold, or `known_cost`, can pass.

    Also the best route found on the way, if any, in rows of the tangents' table: the threshold is lowered to its cost.
    Its moves are among those of the core.
    """
    credit = -bounds.prices.travel * problem.cost.priced_travel(tangents.regions)
    best: StepSequence | None = None
    core = replace(core, threshold=min(core.threshold, known_cost))
    for _ in range(_ROUNDS):
        pruned = prune(core, np.array(bounds.prices.prices), core.threshold + credit)
        if pruned is None:
            break
        before, core = len(core.tail), replace(pruned.core, bound=max(core.bound, pruned.least - credit))
        problem.monitor.progress(f"route: {len(core.tail):,} of {before:,} arcs left, bound {core.bound:.4f}")
        if core.empty:
            break
        found = _route_along(problem, core, pruned.region, pruned.x_m, tangents)
        if found is None or found.outcome.objective >= core.threshold * (1.0 - ROUNDING):
            break
        best, core = found, replace(core, threshold=found.outcome.objective)
    return core, best


def _route_along(
    problem: RouteProblem, core: Core, region: IntArray, x_m: FloatArray, tangents: Tangents
) -> StepSequence | None:
    """Choose the best x for regions (n,) that can be passed at x (n,), with the waits that takes; None: too many."""
    waits = np.maximum(np.ceil(np.abs(np.diff(x_m)) / core.x_step_m - ROUNDING).astype(np.int64), 1)
    rows = np.append(np.repeat(region[:-1], waits), region[-1])
    placed = cheapest_x(problem, tangents.regions, rows) if len(rows) <= core.step_budget else None
    if placed is None:
        return None
    outcome = Outcome(Status.TIME_LIMIT, np.empty(0), placed[1], core.bound, np.inf)
    return with_best_x(problem, StepSequence(rows, placed[0], outcome, len(core.tail), "label setting"), tangents)
