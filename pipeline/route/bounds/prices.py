"""Prices of budgets and of travel: those that make the lower bound on a route's cost as large as possible.

The bound as a function of the prices is the lower envelope of one plane per path (Lagrange duality). Kelley's
method finds its top: shortest paths at the prices so far give planes, a linear program gives the prices to try next.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import linprog

from pipeline.arrays import FloatArray
from pipeline.progress import Progress, silent
from pipeline.route.bounds.budgets import Budget, Prices
from pipeline.route.bounds.shortest_paths import Bounds, cheap_moves, cheapest_path, shortest_paths
from pipeline.route.cost.interface import MoveCost
from pipeline.route.moves.candidates import Moves
from pipeline.route.regions.table import RegionTable

_REACH = 0.3
"""Paths up to this much more costly than the cheapest, relative, are considered: prices need no proof, only quality."""
_TRIES = 40
_CLOSE = 1e-4
_DEAREST = 10.0
"""Prices at which a budget outweighs the whole cost this many times are as good as infinite."""


def priced_bounds(
    regions: RegionTable,
    moves: Moves,
    cost: MoveCost,
    budgets: tuple[Budget, ...],
    progress: Progress = silent,
    shortest: Bounds | None = None,
) -> Bounds:
    """Compute the bounds of `shortest_paths`, with prices on travel and on the budgets where they bind.

    `shortest` are those without any price, if they are known.
    """
    bounds = shortest_paths(regions, moves, cost) if shortest is None else shortest
    travels = cost.counts_x and cost.priced_travel(regions) != 0.0
    if not np.isfinite(bounds.optimum) or not (budgets or travels):
        return bounds
    progress("route: prices for " + " and ".join(["the budgets"] * bool(budgets) + ["travel along X"] * travels))
    prices = _best_prices(regions, moves, cost, budgets, bounds)
    if not prices.charged:
        return replace(bounds, prices=prices)
    return shortest_paths(regions, moves, cost, prices)


def _best_prices(
    regions: RegionTable, moves: Moves, cost: MoveCost, budgets: tuple[Budget, ...], bounds: Bounds
) -> Prices:
    """Climb the envelope over the less costly part of the graph."""
    part = cheap_moves(moves, bounds, (1.0 + _REACH) * bounds.optimum)
    left = np.array([budget.left(regions) for budget in budgets])
    travel, dearest = cost.priced_travel(regions), cost.highest_price(regions)
    scale = bounds.optimum + dearest * abs(travel)
    highest = np.append(_DEAREST * scale / np.maximum(left, 1e-3), dearest if travel else 0.0)
    sign = np.append(np.ones(len(budgets)), -np.sign(travel))
    planes: list[tuple[float, FloatArray]] = []
    prices, best, value = np.zeros(len(highest)), np.zeros(len(highest)), float("-inf")
    for _ in range(_TRIES):
        signed = sign * prices
        paid, excess = _plane(regions, part, cost, Prices(budgets, tuple(signed[:-1].tolist()), -float(signed[-1])))
        planes.append((paid, sign * excess))
        if paid + excess @ signed > value:
            value, best = float(paid + excess @ signed), signed
        top, prices = _top(planes, highest)
        if top - value <= _CLOSE * scale:
            break
    return Prices(budgets, tuple(best[:-1].tolist()), -float(best[-1]))


def _plane(regions: RegionTable, moves: Moves, cost: MoveCost, prices: Prices) -> tuple[float, FloatArray]:
    """Cost of the path that is shortest at these prices, and by how much it exceeds each budget and the travel."""
    path = cheapest_path(regions, moves, cost, prices)
    assert path is not None
    ends = regions, path[:-1], path[1:]
    travel = cost.best_travel(*ends, prices.travel)
    own = cost.offset_m(regions)
    moved = float(travel.sum() + own[path[-1]] - own[path[0]])
    paid = float(cost.least(*ends, prices.travel).sum()) + prices.travel * moved
    spent = np.array([budget.used(*ends).sum() - budget.left(regions) for budget in prices.budgets])
    return paid, np.append(spent, moved - cost.priced_travel(regions))


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
