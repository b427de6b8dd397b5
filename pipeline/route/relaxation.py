"""The relaxation without x and step budget: a shortest path, and with it bounds for every region.

F(j) is the least cost from the start up to region j, B(j) the least cost from j to the goal. Every route
through j costs at least F(j) + B(j), so that all routes cheaper than T lie in the core F + B <= T.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from pipeline.machine.geometry import FloatArray, IntArray
from pipeline.route.moves import Moves
from pipeline.route.regions import RegionTable


@dataclass(frozen=True, eq=False)
class Bounds:
    """Costs of shortest paths; infinite where there is none.

    Attributes
    ----------
    forward, backward : (n,)
        F and B of every region: kappa of all regions left, so F leaves out j itself and B counts it.
    """

    forward: FloatArray
    backward: FloatArray
    start: int

    @property
    def optimum(self) -> float:
        """Cost of the shortest path, infinite when the goal cannot be reached."""
        return float(self.backward[self.start])


def shortest_paths(regions: RegionTable, moves: Moves) -> Bounds:
    """Compute F and B over all moves; the cost of a move is kappa of the region it leaves, (5) and (25)-(26)."""
    graph = moves.graph(regions.kappa)
    forward = dijkstra(graph, indices=regions.start)
    backward = dijkstra(csr_array(graph.T), indices=regions.goal)
    return Bounds(forward, backward, regions.start)


def fewest_moves(regions: RegionTable, moves: Moves) -> int | None:
    """Count the moves of the route with fewest, whatever it costs; None when there is no route."""
    hops = dijkstra(moves.graph(regions.kappa), indices=regions.start, unweighted=True)[regions.goal]
    return int(hops) if np.isfinite(hops) else None


def shortest_route(regions: RegionTable, moves: Moves) -> IntArray:
    """Give the rows of a shortest path from start to goal.

    Raises
    ------
    ValueError
        When the goal cannot be reached.
    """
    distance, previous = dijkstra(moves.graph(regions.kappa), indices=regions.start, return_predecessors=True)
    if not np.isfinite(distance[regions.goal]):
        raise ValueError("the goal cannot be reached from the start")
    rows = [regions.goal]
    while rows[-1] != regions.start:
        rows.append(int(previous[rows[-1]]))
    return np.array(rows[::-1])
