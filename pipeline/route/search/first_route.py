"""A first route where travel along X costs: it caps the threshold, and is there when the time is up.

It goes along a shortest path at the prices of the bounds, with the best x.
"""

import numpy as np

from pipeline.route.bounds.shortest_paths import Bounds, cheap_moves, cheapest_path
from pipeline.route.core.build import build_core
from pipeline.route.moves.candidates import Moves
from pipeline.route.moves.check import line_keys
from pipeline.route.moves.screen import Screening
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.travel_program import Tangents
from pipeline.route.search.best_so_far import BestSoFar
from pipeline.route.search.states import StateGraph
from pipeline.route.search.tightening import tighten_core

_NEAR = 1.1
"""Paths up to this much more costly than the bound, as a factor, are followed until one has admissible moves."""


def offer_first_route(
    problem: RouteProblem, graph: StateGraph, bounds: Bounds, screen: Screening, best: BestSoFar
) -> None:
    """Offer a route along a shortest path of admissible moves, if step budget, windows and budgets allow one there."""
    regions, cost = graph.regions, problem.cost
    moves = cheap_moves(graph.moves, bounds, _NEAR * max(best.excluded, bounds.optimum))
    while (path := cheapest_path(regions, moves, cost, bounds.prices)) is not None:
        along = Moves(path[:-1], path[1:])
        along = along.take(np.argsort(along.source, kind="stable"))
        left = screen(along, moves, graph.base)
        if len(left) < len(moves):
            # What is in the way of a move is mostly in the way of others from or to the same region.
            moves = screen(_beside(_missing(along, left, len(regions)), left, len(regions)), left, graph.base)
            continue
        ceiling = problem.ceiling(regions)
        core = build_core(problem, regions, along, bounds, ceiling)
        if not core.empty:
            tangents = Tangents(regions, cost, bounds.prices.travel)
            core, route = tighten_core(problem, core, bounds, tangents, ceiling)
            best.offer(route, core)
        return


def _missing(some: Moves, moves: Moves, regions: int) -> Moves:
    """Pick those of some moves that are not among the moves (m,)."""
    near = np.zeros(regions, dtype=bool)
    near[some.source] = True
    others = moves.take(near[moves.source])
    known = np.isin(
        line_keys(some.source, some.target, regions, directed=True),
        line_keys(others.source, others.target, regions, directed=True),
    )
    return some.take(~known)


def _beside(some: Moves, moves: Moves, regions: int) -> Moves:
    """Pick the moves (m,) that leave a region that some other moves leave, or arrive where some of those do."""
    left, reached = np.zeros((2, regions), dtype=bool)
    left[some.source] = reached[some.target] = True
    return moves.take(left[moves.source] | reached[moves.target])
