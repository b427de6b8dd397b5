"""The relaxation without x and step budget: a shortest path, and with it bounds for every region.

F(j) is the least cost from the start up to region j, B(j) the least cost from j to the goal. Every route
through j costs at least F(j) + B(j), so that all routes cheaper than T lie in the core F + B <= T.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, dijkstra

from pipeline.arrays import FloatArray, IntArray
from pipeline.parallel import blocks
from pipeline.route.bounds.budgets import FREE, Budget, Prices
from pipeline.route.moves.candidates import Moves
from pipeline.route.regions.table import RegionTable

_BLOCK = 1_000_000
"""Moves whose use of the budgets is computed at once."""


@dataclass(frozen=True, eq=False)
class Bounds:
    """Costs of shortest paths; infinite where there is none.

    Attributes
    ----------
    forward, backward : (n,)
        F and B of every region: kappa of all regions left, so F leaves out j itself and B counts it.
    start : int
        Row of the start.
    prices, refund : Prices, float
        What the budgets cost in F and B, and what of it a route within them gets back.
    """

    forward: FloatArray
    backward: FloatArray
    start: int
    prices: Prices = FREE
    credit: float = 0.0

    @property
    def optimum(self) -> float:
        """No route within the budgets costs less; infinite when the goal cannot be reached."""
        return float(self.backward[self.start]) - self.credit


def shortest_paths(regions: RegionTable, moves: Moves, prices: Prices = FREE) -> Bounds:
    """Compute F and B over all moves; the cost of a move is kappa of the region it leaves, (5) and (25)-(26).

    With `prices`, what the move uses of the budgets costs, too.
    """
    graph = moves.graph(regions.kappa)
    if prices.charged:
        for block in blocks(len(moves), _BLOCK):
            graph.data[block] += prices.penalty(regions, moves.source[block], moves.target[block])
    # Turning the graph round takes as long as a search in it.
    with ThreadPoolExecutor(1) as beside:
        turned = beside.submit(csr_array, graph.T)
        forward = dijkstra(graph, indices=regions.start)
        backward = dijkstra(turned.result(), indices=regions.goal)
    return Bounds(forward, backward, regions.start, prices, prices.credit(regions))


def cheap_moves(moves: Moves, bounds: Bounds, cost: float) -> Moves:
    """Keep the moves between regions that routes of at most this cost, within the budgets, can pass."""
    inside = bounds.forward + bounds.backward <= cost + bounds.credit
    keep = np.flatnonzero(inside[moves.source] & inside[moves.target])
    return moves.take(keep)


def fewest_moves(regions: RegionTable, moves: Moves) -> int | None:
    """Count the moves of the route with fewest, whatever it costs; None when there is no route."""
    reached, previous = breadth_first_order(moves.graph(regions.kappa), regions.start)
    if regions.goal not in reached:
        return None
    row, count = regions.goal, 0
    while row != regions.start:
        row, count = int(previous[row]), count + 1
    return count


def least_use(regions: RegionTable, moves: Moves, budget: Budget) -> float:
    """How much of a budget every route uses, whatever it costs; infinite when there is no route."""
    graph = moves.graph(regions.kappa)
    for block in blocks(len(moves), _BLOCK):
        graph.data[block] = budget.used(regions, moves.source[block], moves.target[block])
    return float(dijkstra(graph, indices=regions.start)[regions.goal])


def shortest_route(regions: RegionTable, moves: Moves, bounds: Bounds) -> IntArray:
    """Give the rows of a shortest path from start to goal, which must exist: B falls along it."""
    rows = [regions.start]
    while rows[-1] != regions.goal:
        # A key of another type would have all moves converted first.
        keys = np.array([rows[-1], rows[-1] + 1], dtype=moves.source.dtype)
        begin, end = np.searchsorted(moves.source, keys)
        ahead = moves.target[begin:end]
        cost = bounds.backward[ahead] + bounds.prices.penalty(regions, moves.source[begin:end], ahead)
        rows.append(int(ahead[np.argmin(cost)]))
    return np.array(rows)
