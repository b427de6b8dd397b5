"""A first route where travel along X costs: it caps the threshold, and is there when the time is up.

It goes along a shortest path at the prices of the bounds, with the best x.
"""

import numpy as np

from pipeline.route.bounds.shortest_paths import Bounds, shortest_paths, shortest_route
from pipeline.route.core.build import build_core
from pipeline.route.moves.candidates import Moves
from pipeline.route.moves.screen import Screening
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.travel_program import Tangents
from pipeline.route.search.best_so_far import BestSoFar
from pipeline.route.search.states import StateGraph
from pipeline.route.search.tightening import tighten_core


def offer_first_route(
    problem: RouteProblem, graph: StateGraph, bounds: Bounds, screen: Screening, best: BestSoFar
) -> None:
    """Offer a route along a shortest path of admissible moves, if step budget, windows and budgets allow one there."""
    moves, tangents = graph.moves, Tangents(graph.regions, problem.cost, bounds.prices.travel)
    least = bounds
    while np.isfinite(least.optimum):
        path = shortest_route(graph.regions, moves, problem.cost, least)
        along = Moves(path[:-1], path[1:])
        along = along.take(np.argsort(along.source, kind="stable"))
        left = screen(along, moves, graph.base)
        if len(left) == len(moves):
            ceiling = problem.options.step_budget * problem.cost.most(graph.regions)
            core = build_core(problem, graph.regions, along, bounds, ceiling)
            if not core.empty:
                core, route = tighten_core(problem, core, bounds, tangents, ceiling)
                best.offer(route, core)
            return
        moves = left
        least = shortest_paths(graph.regions, moves, problem.cost, bounds.prices)
