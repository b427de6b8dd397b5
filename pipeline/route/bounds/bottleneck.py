"""The least largest kappa: the smallest cap on kappa that still leaves a route from start to goal."""

import numpy as np
from scipy.sparse.csgraph import dijkstra

from pipeline.arrays import FloatArray
from pipeline.route.bounds.budgets import Budget
from pipeline.route.bounds.shortest_paths import least_use
from pipeline.route.metric import ROUNDING
from pipeline.route.moves.candidates import Moves
from pipeline.route.regions.table import RegionTable


def least_cap(
    regions: RegionTable,
    moves: Moves,
    values: FloatArray | None = None,
    most_moves: float = np.inf,
    budgets: tuple[Budget, ...] = (),
) -> float:
    """Find the least cap on `values` (n,), kappa by default, that leaves start, goal and a route between them.

    There must be a route of at most `most_moves` moves, and for each budget, taken alone, one that keeps it. Bisection
    over the values; infinite when no cap leaves a route.
    """
    values = regions.kappa if values is None else values
    floor = float(max(values[regions.start], values[regions.goal]))
    caps = np.unique(values[values >= floor])
    if not _connected(regions, moves_within(moves, values, caps[-1]), most_moves, budgets):
        return np.inf
    low, high = -1, len(caps) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if _connected(regions, moves_within(moves, values, caps[middle]), most_moves, budgets):
            high = middle
        else:
            low = middle
    return float(caps[high])


def moves_within(moves: Moves, values: FloatArray, cap: float) -> Moves:
    """Keep the moves between regions whose value is at most `cap`."""
    return moves.take((values[moves.source] <= cap) & (values[moves.target] <= cap))


def _connected(regions: RegionTable, moves: Moves, most_moves: float, budgets: tuple[Budget, ...]) -> bool:
    graph = moves.graph(np.ones(len(moves)), len(regions))
    hops = dijkstra(graph, indices=regions.start, unweighted=True, limit=most_moves)
    return bool(np.isfinite(hops[regions.goal])) and all(
        least_use(regions, moves, budget) <= budget.left(regions) + ROUNDING for budget in budgets
    )
