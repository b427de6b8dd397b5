"""The cost of a route."""

import numpy as np
import pytest

from pipeline.route import RegionTable
from pipeline.route.cost.kappa_sum import KappaSum, region_costs
from pipeline.route.cost.objectives import route_cost


@pytest.fixture
def regions(hand_table) -> RegionTable:
    """Make four regions and two ends."""
    return hand_table([(0.0, 1.0)] * 6, [3.0, 4.0, 5.0, 6.0, 7.0, 8.0])


def test_every_region_costs_its_kappa_and_the_goal_nothing(regions):
    """(25)-(26); the table keeps the goal's kappa."""
    assert region_costs(regions).tolist() == [3.0, 4.0, 5.0, 6.0, 7.0, 0.0]
    assert regions.kappa[regions.goal] == 8.0


def test_all_regions_but_the_goal_are_added_up(regions):
    """(5): start, then three regions."""
    assert (
        route_cost(KappaSum(), regions, np.array([4, 0, 1, 2, 5]), np.zeros(len([4, 0, 1, 2, 5])))
        == 7.0 + 3.0 + 4.0 + 5.0
    )


def test_the_goal_costs_nothing_however_long_it_is_waited_in(regions):
    """(25)-(26): the summation stops once the goal is reached; waiting elsewhere costs."""
    assert (
        route_cost(KappaSum(), regions, np.array([4, 0, 1, 2, 5, 5, 5]), np.zeros(len([4, 0, 1, 2, 5, 5, 5]))) == 19.0
    )
    assert route_cost(KappaSum(), regions, np.array([4, 0, 0, 1, 2, 5]), np.zeros(len([4, 0, 0, 1, 2, 5]))) == 22.0
