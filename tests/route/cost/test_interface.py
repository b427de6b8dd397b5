"""What every cost of moves promises: convex in its travel, tangents below it, bounds at a price below both."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.route.cost.actuator_time import ActuatorTime
from pipeline.route.cost.kappa_integral import KappaIntegral
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.regions.table import RegionTable

X_STEP_M = 0.1
COSTS = [
    KappaSum(),
    KappaIntegral(np.array([X_STEP_M, 0.1, 0.2, 0.3, 0.4])),
    ActuatorTime(np.array([0.5, 0.4, 0.6, 0.1, 0.2]), X_STEP_M),
]

everything = pytest.mark.parametrize("cost", COSTS, ids=lambda cost: type(cost).__name__)
random = given(seed=st.integers(0, 1_000_000))


@pytest.fixture(scope="module")
def draw_regions(hand_table):
    """Give a function that draws a table and all pairs of its rows, waits included."""

    def draw(seed: int, count: int = 6) -> tuple[RegionTable, np.ndarray, np.ndarray, np.random.Generator]:
        random = np.random.default_rng(seed)
        regions = hand_table([(0.0, 1.0)] * count, random.uniform(2.0, 40.0, count))
        regions.controlled[:, 1:] = random.integers(-2, 3, (count, 4)) * [0.1, 0.2, 0.3, 0.4]
        regions.controlled[:-2, 0] = 0.0
        regions.q_m[:] = random.uniform(-0.5, 0.5, (count, 5))
        source, target = (side.ravel() for side in np.indices((count, count)))
        return regions, source, target, random

    return draw


@everything
@random
def test_a_tangent_touches_the_cost_and_is_nowhere_above_it(draw_regions, cost, seed):
    """Whatever dx it is taken at: what programs of tangents find is a lower bound."""
    regions, source, target, random = draw_regions(seed)
    here, there = random.uniform(-X_STEP_M, X_STEP_M, (2, len(source)))
    constant, slope = cost.tangent(regions, source, target, here)
    np.testing.assert_allclose(constant + slope * here, cost.at(regions, source, target, here), atol=1e-9)
    assert (constant + slope * there <= cost.at(regions, source, target, there) + 1e-9).all()


@everything
@random
def test_the_cost_is_convex_in_its_travel(draw_regions, cost, seed):
    """A point between two others costs no more than the mean of theirs."""
    regions, source, target, random = draw_regions(seed)
    a, b = random.uniform(-X_STEP_M, X_STEP_M, (2, len(source)))
    middle = cost.at(regions, source, target, (a + b) / 2.0)
    assert (middle <= (cost.at(regions, source, target, a) + cost.at(regions, source, target, b)) / 2.0 + 1e-9).all()


@everything
@random
def test_no_travel_costs_less_than_the_bound_at_a_price(draw_regions, cost, seed):
    """The bound is not negative, and it is attained at the best travel, which is no longer than a largest move."""
    regions, source, target, random = draw_regions(seed)
    price = random.uniform(-1.0, 1.0) * cost.highest_price(regions)
    least = cost.least(regions, source, target, price)
    assert (least >= 0.0).all()
    own = cost.offset_m(regions)[target] - cost.offset_m(regions)[source]
    for dx in np.linspace(-X_STEP_M, X_STEP_M, 201):
        assert (least <= cost.at(regions, source, target, np.full(len(source), dx)) - price * (dx + own) + 1e-9).all()
    best = cost.best_travel(regions, source, target, price)
    assert (np.abs(best) <= X_STEP_M + 1e-12).all()
    attained = cost.at(regions, source, target, best) - price * (best + own)
    np.testing.assert_allclose(attained, least, atol=1e-9)


@everything
@random
def test_no_move_costs_more_than_the_most(draw_regions, cost, seed):
    """Moves are at most a step long in every coordinate."""
    regions, source, target, random = draw_regions(seed)
    near = (np.abs(regions.controlled[source, 1:] - regions.controlled[target, 1:]) <= [0.1, 0.2, 0.3, 0.4]).all(axis=1)
    dx = random.uniform(-X_STEP_M, X_STEP_M, len(source))
    assert (cost.at(regions, source, target, dx)[near] <= cost.most(regions) + 1e-9).all()


@pytest.mark.parametrize("cost", COSTS[1:], ids=lambda cost: type(cost).__name__)
@random
def test_waiting_costs_in_proportion_to_its_travel(draw_regions, cost, seed):
    """One long wait, or several short ones; none without travel."""
    regions, _, _, random = draw_regions(seed)
    rows, dx = np.arange(len(regions)), random.uniform(-X_STEP_M, X_STEP_M, len(regions))
    np.testing.assert_allclose(cost.at(regions, rows, rows, dx), cost.wait(regions) * np.abs(dx), atol=1e-12)


def test_a_straight_move_costs_its_mean_kappa_times_its_length(hand_table):
    """Three, four and twelve parts of a step make thirteen; kappa 10 and 20 make 15."""
    cost = KappaIntegral(np.ones(5))
    regions = hand_table([(0.0, 9.0)] * 4, [10.0, 20.0, 1.0, 1.0])
    regions.controlled[:2, 1:] = [[0.0, 0.0, 0.0, 0.0], [0.3, 0.4, 0.0, 0.0]]
    ends = np.array([0]), np.array([1])
    assert cost.at(regions, *ends, np.array([1.2]))[0] == pytest.approx(15.0 * 1.3)


def test_the_slowest_actuator_sets_the_time_of_a_move(hand_table):
    """Cart 2 has to go 0.2 m at 0.4 m/s; with 0.1 m along X it is 0.3 m."""
    cost = ActuatorTime(np.array([0.5, 0.4, 0.5, 0.1, 0.1]), 0.1)
    regions = hand_table([(0.0, 9.0)] * 4, [1.0] * 4)
    regions.q_m[:2] = [[0.0, 0.0, 0.0, 1.0, 1.0], [0.1, 0.2, 0.0, 1.01, 1.0]]
    ends = np.array([0]), np.array([1])
    assert cost.at(regions, *ends, np.array([0.0]))[0] == pytest.approx(0.5)
    assert cost.at(regions, *ends, np.array([0.1]))[0] == pytest.approx(0.75)
