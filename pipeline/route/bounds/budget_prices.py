"""Prices of the budgets: those that make the lower bound on a route's cost as large as possible.

The bound as a function of the prices is the lower envelope of one plane per path (Lagrange duality). Kelley's
method finds its top: shortest paths at the prices so far give planes, a linear program gives the prices to try next.
"""

import numpy as np
from scipy.optimize import linprog
from scipy.sparse.csgraph import dijkstra

from pipeline.arrays import FloatArray
from pipeline.progress import Progress, silent
from pipeline.route.bounds.budgets import Budget, Prices
from pipeline.route.bounds.shortest_paths import Bounds, shortest_paths
from pipeline.route.cost import region_costs, route_cost
from pipeline.route.moves.candidates import Moves
from pipeline.route.regions.table import RegionTable

_REACH = 0.3
"""Paths up to this much more costly than the cheapest, relative, are considered: prices need no proof, only quality."""
_TRIES = 40
_CLOSE = 1e-4


def priced_bounds(
    regions: RegionTable, moves: Moves, budgets: tuple[Budget, ...], progress: Progress = silent
) -> Bounds:
    """Compute the bounds of `shortest_paths`, with prices on the budgets where they bind."""
    bounds = shortest_paths(regions, moves)
    if not budgets or not np.isfinite(bounds.optimum):
        return bounds
    progress("route: prices for the budgets")
    prices = Prices(budgets, _best_prices(regions, moves, budgets, bounds))
    if not prices.charged:
        return Bounds(bounds.forward, bounds.backward, bounds.start, prices)
    return shortest_paths(regions, moves, prices)


def _best_prices(regions: RegionTable, moves: Moves, budgets: tuple[Budget, ...], bounds: Bounds) -> tuple[float, ...]:
    """Climb the envelope over the less costly part of the graph."""
    inside = bounds.forward + bounds.backward <= (1.0 + _REACH) * bounds.optimum
    use = inside[moves.source] & inside[moves.target]
    part = moves.take(use)
    left = np.array([budget.left(regions) for budget in budgets])
    # A price at which the budget alone outweighs the whole cost is as good as infinite.
    highest = bounds.optimum / np.maximum(left, 1e-3)
    planes: list[tuple[float, FloatArray]] = []
    prices, best, value = np.zeros(len(budgets)), np.zeros(len(budgets)), float("-inf")
    for _ in range(_TRIES):
        cost, excess = _plane(regions, part, budgets, prices)
        planes.append((cost, excess))
        if cost + excess @ prices > value:
            value, best = float(cost + excess @ prices), prices
        top, prices = _top(planes, highest)
        if top - value <= _CLOSE * bounds.optimum:
            break
    return tuple(best.tolist())


def _plane(
    regions: RegionTable, moves: Moves, budgets: tuple[Budget, ...], prices: FloatArray
) -> tuple[float, FloatArray]:
    """Cost of the path that is shortest at these prices, and by how much it exceeds each budget."""
    graph = moves.graph(region_costs(regions))
    graph.data += Prices(budgets, tuple(prices)).penalty(regions, moves.source, moves.target)
    _, previous = dijkstra(graph, indices=regions.start, return_predecessors=True)
    rows = [regions.goal]
    while rows[-1] != regions.start:
        rows.append(int(previous[rows[-1]]))
    path = np.array(rows[::-1])
    spent = np.array([budget.used(regions, path[:-1], path[1:]).sum() for budget in budgets])
    left = np.array([budget.left(regions) for budget in budgets])
    return route_cost(regions, path), spent - left


def _top(planes: list[tuple[float, FloatArray]], highest: FloatArray) -> tuple[float, FloatArray]:
    """Find the top of the lower envelope of planes cost + excess . prices, for prices from zero to `highest`."""
    costs = np.array([cost for cost, _ in planes])
    slopes = np.array([excess for _, excess in planes])
    objective = np.append(np.zeros(len(highest)), -1.0)
    solution = linprog(
        objective,
        A_ub=np.column_stack([-slopes, np.ones(len(planes))]),
        b_ub=costs,
        bounds=[*((0.0, limit) for limit in highest), (None, None)],
    )
    return -float(solution.fun), solution.x[:-1]
