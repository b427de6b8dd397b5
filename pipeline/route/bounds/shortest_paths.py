"""The relaxation without x and step budget: shortest paths, which bound the cost of routes through every region.

F(j) is the least cost from the start up to region j, B(j) the least cost from j to the goal. Every route
through j costs at least F(j) + B(j), so that all routes cheaper than T lie in the core F + B <= T.
"""

from collections import deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, dijkstra

from pipeline.arrays import FloatArray, IntArray
from pipeline.parallel import blocks, in_parallel
from pipeline.route.bounds.budgets import FREE, Budget, Prices
from pipeline.route.cost.interface import MoveCost
from pipeline.route.metric import ROUNDING
from pipeline.route.moves.candidates import Moves
from pipeline.route.regions.table import RegionTable

_BLOCK = 1_000_000
"""Number of moves whose use of the budgets is computed at a time."""


@dataclass(frozen=True, eq=False)
class Bounds:
    """Costs of shortest paths; infinite where there is none.

    Attributes
    ----------
    forward, backward : (n,)
        F and B of every region: the costs of the moves from the start, and of those to the goal.
    start : int
        Row of the start.
    prices, credit : Prices, float
        What the budgets cost in F and B, and the most that a route within them can pay.
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


def shortest_paths(
    regions: RegionTable, moves: Moves, cost: MoveCost, prices: Prices = FREE, block_size: int = _BLOCK
) -> Bounds:
    """Compute F and B over all moves, each at its least cost at the prices, whatever its dx."""
    graph = priced_graph(regions, moves, cost, prices, block_size)
    # Reversing the graph takes as long as a search in it.
    with ThreadPoolExecutor(1) as reversal:
        reversed_graph = reversal.submit(csr_array, graph.T)
        forward = dijkstra(graph, indices=regions.start)
        backward = dijkstra(reversed_graph.result(), indices=regions.goal)
    return Bounds(forward, backward, regions.start, prices, prices.credit(cost, regions))


def priced_graph(
    regions: RegionTable, moves: Moves, cost: MoveCost, prices: Prices = FREE, block_size: int = _BLOCK
) -> csr_array:
    """Give the moves as a sparse matrix of their least costs at the prices. Shape (n, n)."""
    costs = np.empty(len(moves))

    def price(block: slice) -> None:
        costs[block] = prices.cost(cost, regions, moves.source[block], moves.target[block])

    deque(in_parallel([partial(price, block) for block in blocks(len(moves), block_size)]), maxlen=0)
    return moves.graph(costs, len(regions))


def cheap_moves(moves: Moves, bounds: Bounds, cost: float) -> Moves:
    """Keep the moves between regions that routes of at most this cost, within the budgets, can pass."""
    inside = bounds.forward + bounds.backward <= cost + bounds.credit
    keep = np.flatnonzero(inside[moves.source] & inside[moves.target])
    return moves.take(keep)


def fewest_positions(regions: RegionTable, moves: Moves) -> int | None:
    """Count the positions of the route with fewest, start and goal included, at any cost; None without a route."""
    reached, previous = breadth_first_order(moves.graph(np.ones(len(moves)), len(regions)), regions.start)
    if regions.goal not in reached:
        return None
    row, count = regions.goal, 1
    while row != regions.start:
        row, count = int(previous[row]), count + 1
    return count


def least_use(regions: RegionTable, moves: Moves, budget: Budget, block_size: int = _BLOCK) -> float:
    """Compute how much of a budget every route uses at least, at any cost; infinite when there is no route."""
    graph = moves.graph(np.ones(len(moves)), len(regions))
    for block in blocks(len(moves), block_size):
        graph.data[block] = budget.used(regions, moves.source[block], moves.target[block])
    return float(dijkstra(graph, indices=regions.start)[regions.goal])


def shortest_route(regions: RegionTable, moves: Moves, cost: MoveCost, bounds: Bounds) -> IntArray:
    """Give the rows of a shortest path from start to goal, which must exist, at the prices of its bounds."""
    tight = cheap_moves(moves, bounds, bounds.optimum + ROUNDING * (1.0 + abs(bounds.optimum)))
    path = cheapest_path(regions, tight, cost, bounds.prices)
    assert path is not None
    return path


def cheapest_path(regions: RegionTable, moves: Moves, cost: MoveCost, prices: Prices) -> IntArray | None:
    """Give the rows of a path from start to goal that costs least at the prices; None where there is none."""
    graph = priced_graph(regions, moves, cost, prices)
    least, previous = dijkstra(graph, indices=regions.start, return_predecessors=True)
    return path_to(previous, regions.start, regions.goal) if np.isfinite(least[regions.goal]) else None


def path_to(previous: IntArray, start: int, goal: int) -> IntArray:
    """Follow the predecessors (n,) of a search from the goal back to the start, which must have been reached."""
    rows = [goal]
    while rows[-1] != start:
        rows.append(int(previous[rows[-1]]))
    return np.array(rows[::-1])
