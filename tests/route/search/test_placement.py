"""Placing: the smoothest x where all rules allow it, else the solver's own, and nothing that breaks one."""

import numpy as np
import pytest

from pipeline.errors import NoSolutionError
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.solution import StepSequence
from pipeline.route.search.placement import place_route

ROWS = np.array([2, 0, 1, 3])
STILL = np.full(4, 0.5)


@pytest.fixture
def placed(hand_table, hand_moves, machine, quick_config, vary):
    """Give a function that places four regions in one place, whose smoothest x is made up, within a budget."""
    regions = hand_table([(0.0, 1.0), (0.0, 1.0), (0.5, 0.5), (0.5, 0.5)], [2.0, 3.0, 4.0, 5.0])
    regions.controlled[:, 1] = 0.0

    def choose_x(windows_m, x_step_m, time_limit_s, feasible_m):
        return np.array([0.5, 0.6, 0.4, 0.5])

    def within(travel_m, x_m=STILL):
        config = vary(quick_config, {"route.x_step_m": 1.0, "task.budget.travel_m": travel_m})
        problem = RouteProblem.of(config, machine, regions, hand_moves([]))
        return place_route(problem, StepSequence(ROWS, np.asarray(x_m), None, 0), choose_x)

    return within


def test_the_smoothest_x_is_taken_where_the_budget_allows_it(placed):
    """Carts move along with the platform."""
    found = placed(0.41)
    np.testing.assert_array_equal(found.pose[:, 0], [0.5, 0.6, 0.4, 0.5])
    np.testing.assert_allclose(found.q_m[:, 0], [1.0, 1.6, 1.4, 1.0])
    assert found.objective == 4.0 + 2.0 + 3.0


def test_the_x_of_the_solver_is_taken_where_the_smoothest_breaks_the_budget(placed):
    """It is known to keep it."""
    found = placed(0.39)
    np.testing.assert_array_equal(found.pose[:, 0], STILL)
    np.testing.assert_allclose(found.q_m[:, 0], [1.0, 1.5, 1.5, 1.0])


def test_a_sequence_that_breaks_a_rule_is_refused(placed):
    """Nothing a solver returns is taken on trust."""
    with pytest.raises(NoSolutionError, match=r"task\.budget\.travel_m: 1 used, 0.39 allowed") as caught:
        placed(0.39, [0.5, 1.0, 0.5, 0.5])
    assert caught.value.diagnosis["broken"] == ["task.budget.travel_m: 1 used, 0.39 allowed"]
