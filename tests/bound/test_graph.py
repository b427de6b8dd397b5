"""Tests of the graph: distances are those of Dijkstra's algorithm."""

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from pipeline.bound.graph import FAR, Graph


@pytest.mark.parametrize("seed", range(5))
def test_distances_count_what_is_not_passable(seed: int):
    """Every box that is not passable counts once, on the way and at its ends."""
    rng = np.random.default_rng(seed)
    n = 60
    nodes = rng.permutation(200)[:n]
    edges = nodes[rng.integers(0, n, (80, 2))]
    edges = edges[edges[:, 0] != edges[:, 1]]
    passable = rng.random(n) < 0.5
    graph = Graph(nodes, np.concatenate([edges, [[nodes[0], 201]]]), np.zeros(n, dtype=bool), passable)
    place = np.full(202, -1)
    place[nodes] = np.arange(n)
    a, b = place[edges].T
    cost = np.where(passable, 1e-6, 1.0)
    matrix = csr_array((np.concatenate([cost[b], cost[a]]), (np.concatenate([a, b]), np.concatenate([b, a]))), (n, n))
    matrix.data = np.minimum(matrix.data, 1.0)
    matrix = csr_array((cost[matrix.indices], matrix.indices, matrix.indptr), (n, n))
    expected = dijkstra(matrix, indices=0) + cost[0]
    found = graph.distances(nodes[:1])
    assert (found == np.where(np.isfinite(expected), np.floor(np.nan_to_num(expected, posinf=0.0) + 0.1), FAR)).all()


def test_the_edge_of_the_chart_joins():
    """Boxes without a common face are joined if both touch an edge behind which the chart goes on."""
    nodes, edges = np.arange(4), np.array([[0, 1], [2, 3]])
    passable = np.zeros(4, dtype=bool)
    apart = Graph(nodes, edges, np.array([False, True, False, False]), passable)
    assert apart.distances(nodes[:1]).tolist() == [1, 2, FAR, FAR]
    joined = Graph(nodes, edges, np.array([False, True, True, False]), passable)
    assert joined.distances(nodes[:1]).tolist() == [1, 2, 3, 4]
