"""The objectives of `route.objective`: the least cost, or the least largest kappa and then the least sum.

An objective is a row of `OBJECTIVES`: how its optimum is found and proven over the moves admitted so far.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pipeline.route.bounds.bottleneck import least_cap, moves_within
from pipeline.route.bounds.prices import priced_bounds
from pipeline.route.bounds.shortest_paths import Bounds
from pipeline.route.deadline import OutOfTimeError
from pipeline.route.moves.screen import Screen
from pipeline.route.problem import RouteProblem
from pipeline.route.search.best_so_far import Optimum
from pipeline.route.search.optimum import find_optimum
from pipeline.route.search.states import StateGraph

Find = Callable[[RouteProblem, StateGraph, Bounds, Screen, Optimum | None], Optimum | None]
"""Finds an optimum; the parameters are those of `find_best`."""


@dataclass(frozen=True)
class Objective:
    """What makes a route the best one.

    Attributes
    ----------
    find : callable
        Finds its optimum.
    single_program : bool
        That the optimum of one program over all moves is its optimum.
    """

    find: Find
    single_program: bool


def find_best(
    problem: RouteProblem, graph: StateGraph, bounds: Bounds, screen: Screen, before: Optimum | None = None
) -> Optimum | None:
    """Find the best sequence over the moves not known to be bad; None: there is none (proven).

    `bounds` are those of the graph, `before` is the best of the previous round, which had more moves. When the time
    runs out it is the best one found so far, and not `proven`.

    Raises
    ------
    OutOfTimeError
        When the time runs out before a route is found.
    """
    return OBJECTIVES[problem.options.objective].find(problem, graph, bounds, screen, before)


def _least_cost(
    problem: RouteProblem, graph: StateGraph, bounds: Bounds, screen: Screen, before: Optimum | None
) -> Optimum | None:
    """Find the least cost."""
    left = replace(graph, moves=screen.without_bad(graph.moves, graph.base))
    return find_optimum(problem, left, bounds, before.bound if before else 0.0, screen.screen)


def _least_largest(
    problem: RouteProblem, graph: StateGraph, bounds: Bounds, screen: Screen, before: Optimum | None
) -> Optimum | None:
    """Find the least cap on kappa under which there is a sequence: the graph's own, or above it by bisection.

    The graph ignores x and combined budgets, and core after core forbids moves; only a solve decides about a cap.
    """
    kappa, progress = problem.regions.kappa, problem.monitor.progress
    progress("route: least largest kappa")
    moves = screen.without_bad(graph.moves, graph.base)
    least = least_cap(graph.regions, moves, most_moves=problem.options.step_budget - 1, budgets=problem.budgets)
    least = max(least, before.cap if before else 0.0)
    solve = partial(_least_sum_under, problem, graph, screen, before)
    if not np.isfinite(least) or (best := solve(least)) is not None:
        return best if np.isfinite(least) else None
    if (best := solve(float(kappa.max()))) is None:
        return None
    caps = np.unique(kappa[kappa > least])
    low, high = -1, int(np.searchsorted(caps, kappa[best.sequence.region].max()))
    try:
        while high - low > 1:
            middle = (low + high) // 2
            progress(f"route: least largest kappa, between {caps[max(low, 0)]:.3f} and {caps[high]:.3f}")
            if (found := solve(float(caps[middle]))) is None:
                low = middle
            else:
                high, best = int(np.searchsorted(caps, kappa[found.sequence.region].max())), found
    except OutOfTimeError:
        return replace(best, proven=False, cap=least)
    # The best sequence under a larger cap that keeps this one is also the best under this one.
    return replace(best, cap=float(caps[high]))


def _least_sum_under(
    problem: RouteProblem, graph: StateGraph, screen: Screen, before: Optimum | None, cap: float
) -> Optimum | None:
    """Find the least sum of kappa among sequences whose kappa is nowhere above a cap."""
    moves = moves_within(screen.without_bad(graph.moves, graph.base), graph.regions.kappa, cap)
    bounds = priced_bounds(graph.regions, moves, problem.cost, problem.budgets, problem.monitor.progress)
    if not np.isfinite(bounds.optimum):
        return None
    at_least = before.bound if before and before.cap >= cap else 0.0
    found = find_optimum(problem, replace(graph, moves=moves), bounds, at_least, screen.screen)
    return None if found is None else replace(found, cap=cap)


OBJECTIVES = {
    "integral": Objective(_least_cost, single_program=False),
    "sum": Objective(_least_cost, single_program=True),
    "bottleneck": Objective(_least_largest, single_program=False),
    "time": Objective(_least_cost, single_program=False),
}
