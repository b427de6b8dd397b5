"""The order of a tour."""

from itertools import permutations

import numpy as np
import pytest

from pipeline.atlas.tour import tour_cost, tour_order


@pytest.mark.parametrize("seed", range(8))
def test_few_stations_are_in_a_good_order(seed: int):
    """All are visited once, at most a twentieth longer than the best of all orders, costs being those of a plane."""
    places = np.random.default_rng(seed).uniform(size=(7, 2))
    costs = np.linalg.norm(places[:, None] - places, axis=2)
    order = tour_order(costs, 0, range(1, 7), 0)
    assert sorted(order) == list(range(1, 7))
    best = min(tour_cost(costs, (0, *other, 0)) for other in permutations(range(1, 7)))
    assert tour_cost(costs, (0, *order, 0)) <= 1.05 * best


def test_direction_counts():
    """Round a one-way street there is one order."""
    costs = np.full((5, 5), 10.0)
    for k in range(5):
        costs[k, (k + 1) % 5] = 1.0
    assert tour_order(costs, 0, [3, 1, 4, 2], 0) == [1, 2, 3, 4]


def test_a_tour_goes_on_from_where_it_is():
    """First and last station differ where a part was driven already."""
    costs = np.abs(np.subtract.outer(np.arange(5.0), np.arange(5.0)))
    assert tour_order(costs, 4, [1, 3, 2], 0) == [3, 2, 1]
    assert tour_order(costs, 4, [], 0) == []
