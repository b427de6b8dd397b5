"""First routes where travel along X costs: they cap the threshold, and are there when the time is up.

One goes along a shortest path, at the prices of the bounds: with the best x it often is the optimum. Where it is not
near the bound, a beam search looks for better ones among the routes that cost little more than the bound.
"""

from collections.abc import Callable

import numpy as np

from pipeline.arrays import IntArray
from pipeline.route.bounds.shortest_paths import Bounds, cheap_moves, shortest_paths, shortest_route
from pipeline.route.moves.candidates import Moves
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.core import build_core, core_bytes
from pipeline.route.programs.solution import StepSequence
from pipeline.route.programs.travel_program import Tangents
from pipeline.route.search.beam import beam_route
from pipeline.route.search.best_so_far import BestSoFar
from pipeline.route.search.core_optimum import solve_core
from pipeline.route.search.outer_approximation import with_best_x
from pipeline.route.search.states import StateGraph
from pipeline.solvers.highs import Outcome
from pipeline.status import Status

Screening = Callable[[Moves, Moves, IntArray], Moves]
"""Follows the moves of a core (first), and leaves all known to be bad out of others (second); rows are mapped to
those of the region table by the third, (n,)."""

_NEAR = 1.01
"""A route this near the bound, as a factor, is good enough to start with."""
_ABOVE = (1.02, 1.05, 1.1, 1.2, 1.4)
"""Beams search routes that cost up to this much, in bounds, until their core is too large."""
_MOST_ARCS = 500_000
"""Larger cores are not searched."""
_TRIES = 10
"""Beams per core: moves that fail when followed are left out of the next."""


def offer_first_routes(
    problem: RouteProblem, graph: StateGraph, bounds: Bounds, screen: Screening, best: BestSoFar
) -> None:
    """Offer routes whose moves are admissible."""
    _follow_shortest(problem, graph, bounds, screen, best)
    if best.objective <= _NEAR * best.excluded:
        return
    for factor in _ABOVE:
        threshold = min(factor * best.excluded, best.objective)
        if not _search(problem, graph, bounds, screen, best, threshold) or threshold == best.objective:
            return


def _follow_shortest(
    problem: RouteProblem, graph: StateGraph, bounds: Bounds, screen: Screening, best: BestSoFar
) -> None:
    """Offer the best route along a shortest path of admissible moves."""
    moves, tangents = graph.moves, Tangents(graph.regions, problem.cost, bounds.prices.travel)
    least = bounds
    while np.isfinite(least.optimum):
        path = shortest_route(graph.regions, moves, problem.cost, least)
        along = _moves_of(path)
        left = screen(along, moves, graph.base)
        if len(left) == len(moves):
            ceiling = problem.options.step_budget * problem.cost.most(graph.regions)
            core = build_core(problem, graph.regions, along, bounds, ceiling)
            if not core.empty:
                best.offer(solve_core(problem, core, bounds, tangents), core)
            return
        moves = left
        least = shortest_paths(graph.regions, moves, problem.cost, bounds.prices)


def _search(
    problem: RouteProblem, graph: StateGraph, bounds: Bounds, screen: Screening, best: BestSoFar, threshold: float
) -> bool:
    """Offer what a beam search finds among the routes of at most a cost; whether larger costs may be searched."""
    needed = core_bytes(bounds, threshold, problem.options.step_budget)
    if needed > 1e9 * problem.options.memory_gb:
        return False
    moves = cheap_moves(graph.moves, bounds, threshold)
    tangents = Tangents(graph.regions, problem.cost, bounds.prices.travel)
    for _ in range(_TRIES):
        core = build_core(problem, graph.regions, moves, bounds, threshold)
        if core.empty or len(core.tail) > _MOST_ARCS:
            return core.empty
        problem.monitor.progress(f"route: first route, in a core of {core.regions:,} regions")
        route = beam_route(problem, core, bounds, graph.regions)
        if route is None:
            return not problem.deadline.passed
        left = screen(_moves_of(route[0]), moves, graph.base)
        if len(left) == len(moves):
            outcome = Outcome(Status.TIME_LIMIT, np.empty(0), np.inf, core.bound, np.inf)
            found = StepSequence(*route, outcome, len(core.tail), "beam search")
            best.offer(with_best_x(problem, found, tangents), core)
            return True
        moves = left
    return True


def _moves_of(rows: IntArray) -> Moves:
    """Give the moves of a route, each once, without its waits."""
    pairs = np.unique(np.column_stack([rows[:-1], rows[1:]]), axis=0)
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    return Moves(pairs[:, 0], pairs[:, 1])
