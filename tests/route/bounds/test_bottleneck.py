"""The least cap on kappa that leaves a route in the graph."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.route.bounds.bottleneck import least_cap, moves_within
from pipeline.route.bounds.shortest_paths import shortest_paths
from pipeline.route.cost.kappa_sum import KappaSum


@settings(max_examples=100)
@given(st.integers(0, 1_000_000))
def test_the_cap_of_the_graph_is_the_least_with_a_way(random_problem, seed):
    """Tried value by value."""
    regions, moves, positions = random_problem(seed)
    expected = np.inf
    for cap in np.unique(regions.kappa):
        left = moves_within(moves, regions.kappa, cap)
        ends = max(regions.kappa[regions.start], regions.kappa[regions.goal])
        if cap >= ends and np.isfinite(shortest_paths(regions, left, KappaSum()).optimum):
            expected = cap
            break
    assert least_cap(regions, moves) == expected
    assert least_cap(regions, moves, most_moves=positions - 1) >= expected
