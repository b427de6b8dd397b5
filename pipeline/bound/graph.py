"""Which boxes can be reached from which, and over how many that are not passable."""

import numpy as np
from scipy.sparse import csr_array

from pipeline.arrays import BoolArray, IntArray

FAR = np.iinfo(np.int32).max // 4
"""Distance of what cannot be reached."""


class Graph:
    """Boxes joined by common faces, and those at the edge of the chart by what is behind it."""

    def __init__(self, nodes: IntArray, edges: IntArray, at_edge: BoolArray, passable: BoolArray) -> None:
        """Join some nodes (n,), in ascending order or not, by those edges (m, 2) that lead to others of them."""
        n = len(nodes)
        place = np.full(int(max(nodes.max(initial=0), edges.max(initial=0))) + 1, -1)
        place[nodes] = np.arange(n)
        a, b = place[edges].T
        inside = (a >= 0) & (b >= 0)
        a, b = a[inside], b[inside]
        ones = np.ones(2 * len(a), dtype=np.int8)
        matrix = csr_array((ones, (np.concatenate([a, b]), np.concatenate([b, a]))), shape=(n, n))
        self._indptr, self._indices = matrix.indptr, matrix.indices
        self._edge, self._passable, self._place = at_edge, passable, place

    def distances(self, sources: IntArray) -> IntArray:
        """Count the boxes that are not passable on the cheapest way from a set of nodes, ends included. Shape (n,)."""
        distance = np.full(len(self._passable), FAR)
        waiting, ready = np.zeros(len(distance), dtype=bool), np.zeros(len(distance), dtype=bool)
        edge_open = bool(self._edge.any())
        level, new = 0, self._place[sources]
        while True:
            waiting[new], ready[new] = True, self._passable[new]
            free = np.flatnonzero(ready)
            if not free.size:
                level += 1
                free = np.flatnonzero(waiting)
                if not free.size:
                    return distance
            waiting[free], ready[free] = False, False
            distance[free] = level
            new = self._neighbours(free)
            if edge_open and self._edge[free].any():
                edge_open = False
                new = np.concatenate([new, np.flatnonzero(self._edge)])
            new = new[distance[new] == FAR]

    def _neighbours(self, nodes: IntArray) -> IntArray:
        counts = self._indptr[nodes + 1] - self._indptr[nodes]
        shift = np.repeat(self._indptr[nodes] - np.concatenate([[0], np.cumsum(counts)[:-1]]), counts)
        return np.asarray(self._indices[np.arange(len(shift)) + shift])
