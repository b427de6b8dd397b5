"""Least times: closed forms, limits scaled, and a program over jerk that knows nothing of them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from pipeline.machine import Machine
from pipeline.retime.quality.least_time import least_times_s, rest_to_rest_s

numbers = st.floats(0.01, 10.0)


@pytest.mark.parametrize("distance", [0.9, 0.3, 0.1, 0.01])
def test_without_jerk_limits_it_is_a_trapezoid_or_bang_bang(distance: float) -> None:
    """D / v + v / a where the top speed is reached, 2 sqrt(D / a) where it is not."""
    expected = distance / 0.5 + 0.25 if distance > 0.125 else 2.0 * np.sqrt(distance / 2.0)
    assert rest_to_rest_s(distance, 0.5, 2.0) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("distance", "velocity", "acceleration", "jerk", "expected"),
    [
        (2.0, 1e9, 1e9, 1.0, 4.0),  # four phases of a second each: 4 (D / 2 j)^(1/3)
        (4.0, 1.0, 1e9, 1.0, 6.0),  # v reached in 2 sqrt(v / j) = 2 s, two seconds of it at v
        (6.0, 1e9, 1.0, 1.0, 6.0),  # u = 2: j, a and j again, a second each, and the same to stop
        (8.0, 2.0, 1.0, 1.0, 7.0),  # all seven phases: D / v + v / a + a / j
    ],
)
def test_with_jerk_limits_it_is_the_double_s(
    distance: float, velocity: float, acceleration: float, jerk: float, expected: float
) -> None:
    """Distances at which every phase lasts a second, for each set of limits that can bind."""
    assert rest_to_rest_s(distance, velocity, acceleration, jerk) == pytest.approx(expected)


def _shortest_by_programs(distance: float, velocity: float, acceleration: float, jerk: float) -> float:
    """Bisect the duration; the farthest that can be reached in it is a linear program over even steps of jerk."""
    n = 120
    ones = np.tril(np.ones((n, n)))

    def farthest(duration: float) -> float:
        h = duration / n
        by_acceleration = h * ones
        by_velocity = h * (ones @ by_acceleration - 0.5 * by_acceleration)
        position = h * (by_velocity[:-1].sum(axis=0) + h**2 / 6.0) + h**2 / 2.0 * by_acceleration[:-1].sum(axis=0)
        rows, limits = np.vstack([by_acceleration, by_velocity]), np.repeat([acceleration, velocity], n)
        found = linprog(
            -position,
            A_ub=np.vstack([rows, -rows]),
            b_ub=np.tile(limits, 2),
            A_eq=np.vstack([by_acceleration[-1], by_velocity[-1]]),
            b_eq=[0.0, 0.0],
            bounds=(-jerk, jerk),
        )
        return float(-found.fun)

    low, high = 0.0, 10.0
    for _ in range(14):
        middle = (low + high) / 2.0
        low, high = (low, middle) if farthest(middle) >= distance else (middle, high)
    return high


@pytest.mark.parametrize("limits", [(0.3, 0.5, 2.0, 40.0), (0.02, 0.1, 0.5, 10.0), (1.7, 0.5, 0.7, 1.0)])
def test_a_program_over_jerk_finds_no_shorter_time(limits: tuple[float, float, float, float]) -> None:
    """Even steps of jerk reach the distance within two per cent of the least time, and never before."""
    least, found = rest_to_rest_s(*limits), _shortest_by_programs(*limits)
    assert least * (1.0 - 1e-3) <= found <= least * 1.02


@given(numbers, numbers, numbers, numbers)
def test_less_of_a_limit_never_makes_it_faster(
    distance: float, velocity: float, acceleration: float, jerk: float
) -> None:
    """Half of a limit, or more to go, takes as long or longer; twice the time for d, v / 2, a / 4, j / 8."""
    least = rest_to_rest_s(distance, velocity, acceleration, jerk)
    rounding = least * (1.0 - 1e-12)
    assert rest_to_rest_s(distance * 1.1, velocity, acceleration, jerk) > rounding
    assert rest_to_rest_s(distance, velocity / 2.0, acceleration, jerk) >= rounding
    assert rest_to_rest_s(distance, velocity, acceleration / 2.0, jerk) >= rounding
    assert rest_to_rest_s(distance, velocity, acceleration, jerk / 2.0) >= rounding
    slow = rest_to_rest_s(distance, velocity / 2.0, acceleration / 4.0, jerk / 8.0)
    assert slow == pytest.approx(2.0 * least, rel=1e-12)
    assert rest_to_rest_s(0.0, velocity, acceleration, jerk) == 0.0


def test_a_locked_actuator_takes_no_time(machine: Machine) -> None:
    """Its velocity limit is zero, and so is the distance that tasks give it."""
    locked = replace(machine, velocity_mps=np.array([0.5, 0.5, 0.5, 0.0, 0.1]))
    assert least_times_s(locked, np.full(5, 0.1))[3] == 0.0
