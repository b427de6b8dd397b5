"""Cores without what no route can pass, where travel along X costs; and the routes that are found on the way."""

from dataclasses import replace

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.bounds.shortest_paths import Bounds
from pipeline.route.core.build import Core
from pipeline.route.core.pruning import prune
from pipeline.route.core.x_grid import route_on_grid
from pipeline.route.metric import ROUNDING
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.solution import StepSequence
from pipeline.route.programs.travel_program import Tangents
from pipeline.route.search.best_so_far import CLOSED
from pipeline.route.search.label_setting import SOLVER
from pipeline.route.search.outer_approximation import with_best_x
from pipeline.route.search.x_positions import cheapest_x
from pipeline.solvers.highs import Outcome
from pipeline.status import Status

_Way = tuple[IntArray, FloatArray]
"""Rows of the tangents' table and x (n,), moves longer than a largest one along X included."""
_GRIDS = (1, 2, 3, 4)
"""Parts of a largest move along X, at which routes are looked for until one meets the bound."""
_SMALL = 300
"""Cores of at most this many arcs are solved at once: no route is looked for in them."""


def tighten_core(
    problem: RouteProblem, core: Core, bounds: Bounds, tangents: Tangents, known_cost: float
) -> tuple[Core, StepSequence | None]:
    """Leave out of a core that is not empty what no route of at most its threshold, or `known_cost`, can pass.

    Also the best route found on the way, if any, in rows of the tangents' table: the threshold is lowered to its cost.
    Its moves are among those of the core.
    """
    core, best = replace(core, threshold=min(core.threshold, known_cost)), None
    core, way = _pruned(problem, core, bounds, tangents)
    prices = np.array(bounds.prices.prices)
    for per_move in (0, *_GRIDS):
        if per_move:
            way = route_on_grid(problem, core, tangents.regions, prices, per_move)
        found = None if way is None else _route_along(problem, core, way, tangents)
        if found is not None and found.outcome.objective < core.threshold:
            best, core = found, replace(core, threshold=found.outcome.objective)
        if core.threshold <= core.bound * (1.0 + CLOSED) or len(core.tail) <= _SMALL or problem.deadline.passed:
            break
    return core if best is None or core.empty else _pruned(problem, core, bounds, tangents)[0], best


def _pruned(problem: RouteProblem, core: Core, bounds: Bounds, tangents: Tangents) -> tuple[Core, _Way | None]:
    """Leave out of a core what labels say no route can pass; also the cheapest way, if any."""
    credit = -bounds.prices.travel * problem.cost.priced_travel(tangents.regions)
    pruned = prune(core, np.array(bounds.prices.prices), core.threshold + credit)
    if pruned is None:
        return core, None
    left = replace(pruned.core, bound=max(core.bound, pruned.least - credit))
    problem.monitor.progress(f"route: {len(left.tail):,} of {len(core.tail):,} arcs left, bound {left.bound:.4f}")
    return left, None if left.empty else (pruned.region, pruned.x_m)


def _route_along(problem: RouteProblem, core: Core, way: _Way, tangents: Tangents) -> StepSequence | None:
    """Choose the best x for the regions of a way, with the waits that its x take; None where none keeps all rules."""
    region, x_m = way
    waits = np.maximum(np.ceil(np.abs(np.diff(x_m)) / core.x_step_m - ROUNDING).astype(np.int64), 1)
    rows = np.append(np.repeat(region[:-1], waits), region[-1])
    placed = cheapest_x(problem, tangents.regions, rows) if len(rows) <= core.step_budget else None
    if placed is None:
        return None
    outcome = Outcome(Status.TIME_LIMIT, np.empty(0), placed[1], core.bound, np.inf)
    return with_best_x(problem, StepSequence(rows, placed[0], outcome, len(core.tail), SOLVER), tangents)
