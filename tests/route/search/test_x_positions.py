"""Choice of x for every step."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from pipeline.route.search.x_positions import smoothest_x
from pipeline.solvers import Outcome
from pipeline.status import Status


def _fixed_ends(start, goal, n, low=-10.0, high=10.0):
    windows = np.tile([low, high], (n, 1))
    windows[0], windows[-1] = start, goal
    return windows


def test_x_that_may_stay_stays():
    """Same x at both ends and wide windows: nothing moves."""
    windows = _fixed_ends(1.02, 1.02, 12)
    np.testing.assert_allclose(smoothest_x(windows, 0.1, 10.0, np.zeros(12)), 1.02, atol=1e-7)


def test_a_way_without_obstacles_is_divided_evenly():
    """The least sum of squares with fixed ends is a straight line."""
    windows = _fixed_ends(0.0, 1.0, 21)
    np.testing.assert_allclose(smoothest_x(windows, 0.1, 10.0, np.zeros(21)), np.linspace(0, 1, 21), atol=1e-6)


def test_windows_on_the_way_are_met_where_they_begin():
    """A detour goes just as far as it must, straight there and straight back."""
    windows = _fixed_ends(0.0, 0.0, 9)
    windows[4] = 0.2, 5.0
    expected = [0.0, 0.05, 0.1, 0.15, 0.2, 0.15, 0.1, 0.05, 0.0]
    np.testing.assert_allclose(smoothest_x(windows, 0.1, 10.0, np.zeros(9)), expected, atol=1e-6)


def test_the_largest_move_per_step_is_kept():
    """Where there is only one way in time, it is that: full steps, as long as it takes."""
    windows = _fixed_ends(0.0, 0.4, 7)
    windows[:3] = 0.0, 0.0
    travelled = smoothest_x(windows, 0.1, 10.0, np.zeros(7))
    np.testing.assert_allclose(travelled, [0.0, 0.0, 0.0, 0.1, 0.2, 0.3, 0.4], atol=1e-7)


@settings(max_examples=40)
@given(st.integers(0, 1_000_000))
def test_it_is_the_smoothest_of_all_feasible_ones(seed):
    """Windows and steps hold, and a general-purpose optimiser finds nothing smoother."""
    random = np.random.default_rng(seed)
    n, x_step_m = int(random.integers(2, 8)), 0.5
    feasible = np.cumsum(random.uniform(-x_step_m, x_step_m, n))
    windows = feasible[:, None] + np.column_stack([-random.uniform(0.0, 0.4, n), random.uniform(0.0, 0.4, n)])
    windows[[0, -1]] = feasible[[0, -1], None]
    x = smoothest_x(windows, x_step_m, 10.0, feasible)
    assert (x >= windows[:, 0]).all()
    assert (x <= windows[:, 1]).all()
    assert (np.abs(np.diff(x)) <= x_step_m + 1e-8).all()
    reference = minimize(
        lambda x: np.sum(np.diff(x) ** 2),
        feasible,
        bounds=windows,
        method="SLSQP",
        constraints={"type": "ineq", "fun": lambda x: np.concatenate([x_step_m - np.diff(x), x_step_m + np.diff(x)])},
        options={"ftol": 1e-12, "maxiter": 500},
    )
    assert np.sum(np.diff(x) ** 2) == pytest.approx(reference.fun, abs=1e-6)


@pytest.mark.parametrize(
    "outcome",
    [
        Outcome(Status.TIME_LIMIT, np.zeros(3), 0.0, 0.0, 0.0),
        Outcome(Status.OPTIMAL, np.empty(0), np.inf, 0.0, 0.0),
    ],
)
def test_what_is_known_to_be_feasible_is_kept_when_the_program_fails(outcome):
    """Smoothness is optional: a route without it is still the optimum."""
    feasible = np.array([0.0, 0.05, 0.1])
    found = smoothest_x(_fixed_ends(0.0, 0.1, 3), 0.1, 10.0, feasible, solve=lambda program, time_limit_s: outcome)
    assert found is feasible
