"""Label setting over a core; that it finds the optimum of brute force is tested with all that a task asks for."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.route.bounds.budgets import Budget, Prices
from pipeline.route.bounds.shortest_paths import shortest_paths
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.deadline import Deadline
from pipeline.route.programs.core_program import build_core_program, read_core
from pipeline.route.programs.solution import solve_steps
from pipeline.route.search.label_setting import solve_labels
from pipeline.status import Status

ENDLESS = Deadline.after(np.inf)


def a_core(random_problem, core_of, seed: int, travel_m: float | None):
    """Make a core of all routes of a random problem, with a budget of travel where one is given."""
    regions, moves, positions = random_problem(seed)
    budgets = () if travel_m is None else (Budget("travel_m", travel_m, (1, 2), travels=True),)
    bounds = shortest_paths(regions, moves, KappaSum())
    bounds = replace(bounds, prices=Prices(budgets, (0.0,) * len(budgets)))
    return core_of(regions, moves, bounds, 1000.0, positions, 1.0)


@settings(max_examples=200)
@given(
    seed=st.integers(0, 1_000_000),
    travel_m=st.one_of(st.none(), st.floats(1.0, 25.0)),
    price=st.floats(0.0, 3.0),
    cost=st.sampled_from([np.inf, 60.0]),
)
def test_labels_and_the_program_agree(random_problem, core_of, seed, travel_m, price, cost):
    """Whatever the prices: the same optimum as HiGHS over the same core, or the same proof that there is none."""
    core = a_core(random_problem, core_of, seed, travel_m)
    if core.empty:
        return
    expected = solve_steps(build_core_program(core), lambda values: read_core(values, core), 60.0)
    prices = np.full(len(core.budgets), price)
    found = solve_labels(core, prices, ENDLESS, cost)
    if expected.outcome.status is Status.INFEASIBLE or expected.outcome.objective > cost:
        assert found.outcome.status is Status.INFEASIBLE
        assert len(found.region) == 0
        return
    assert found.outcome.status is Status.OPTIMAL
    assert found.outcome.objective == pytest.approx(expected.outcome.objective)
    assert found.outcome.bound == found.outcome.objective
    some = solve_labels(core, prices, ENDLESS, width=1)
    assert some.outcome.objective >= found.outcome.objective - 1e-9
    assert some.outcome.bound <= found.outcome.objective + 1e-9
    assert some.outcome.status is not Status.OPTIMAL or some.outcome.objective == pytest.approx(found.outcome.objective)


@pytest.fixture
def two_ways(hand_table, hand_moves, core_of):
    """Give a function that makes the core of two ways from x 0 to x 0, with a budget of travel.

    Over a window that begins at 2: cost 2 and four metres; round it: cost 51 and none.
    """
    far, near, start, goal = range(4)
    regions = hand_table([(2.0, 3.0), (0.0, 0.5), (0.0, 0.0), (0.0, 0.0)], [1.0, 50.0, 1.0, 1.0])
    regions.controlled[:, 1] = 0.0
    moves = hand_moves([(start, far), (far, goal), (start, near), (near, goal)])

    def core(travel_m: float):
        budget = Budget("travel_m", travel_m, (1, 2), travels=True)
        bounds = replace(shortest_paths(regions, moves, KappaSum()), prices=Prices((budget,), (0.0,)))
        return core_of(regions, moves, bounds, 100.0, 3, 2.0)

    return core


@pytest.mark.parametrize(("travel_m", "cost"), [(4.0, 2.0), (3.9, 51.0)])
def test_the_way_along_x_counts(two_ways, travel_m, cost):
    """What is used of a budget of travel includes what the windows of x ask for."""
    found = solve_labels(two_ways(travel_m), np.zeros(1), ENDLESS)
    assert found.outcome.objective == cost
    assert np.abs(np.diff(found.x_m)).sum() <= travel_m


def test_no_time_proves_nothing(two_ways):
    """The bound is the core's, and a search of a given width still finds a route."""
    core, late = two_ways(4.0), Deadline(1.0, 0.0)
    nothing = solve_labels(core, np.zeros(1), late)
    assert nothing.outcome.status is Status.TIME_LIMIT
    assert nothing.outcome.bound == pytest.approx(core.bound)
    assert len(nothing.region) == 0
    assert solve_labels(core, np.zeros(1), late, width=5).outcome.objective == 2.0
