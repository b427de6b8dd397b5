"""The quality of a motion: reversals that are known; least times against closed forms, the planner and a program."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PPoly
from scipy.optimize import linprog

from pipeline.machine import Machine
from pipeline.retime import Trajectory, measure_quality, slowed
from pipeline.retime.fastest import plan
from pipeline.retime.motion_quality import least_times_s, rest_to_rest_s, sign_changes

numbers = st.floats(0.01, 10.0)


@pytest.mark.parametrize("distance", [0.9, 0.3, 0.1, 0.01])
def test_without_jerk_limits_it_is_a_trapezoid_or_bang_bang(distance: float) -> None:
    """D / v + v / a where the top speed is reached, 2 sqrt(D / a) where it is not."""
    expected = distance / 0.5 + 0.25 if distance > 0.125 else 2.0 * np.sqrt(distance / 2.0)
    assert rest_to_rest_s(distance, 0.5, 2.0) == pytest.approx(expected)


def test_the_planner_finds_the_same_time(line, machine: Machine) -> None:
    """Along a line of one actuator's own, the fastest law takes the least time; a metre, and a centimetre."""
    for travel_m in (0.9, 0.01):
        trajectory = plan(line(travel_m), 1_000)
        quality = measure_quality(trajectory)
        assert quality.time_ratio == pytest.approx(1.0, abs=1e-3)
        assert quality.least_times_s[:3] == pytest.approx([rest_to_rest_s(travel_m, 0.5, 2.0)] * 3)
        assert quality.least_times_s[3:] == (0.0, 0.0)


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


def test_signs_count_above_the_threshold() -> None:
    """Small values between two of one sign are no change; between two of different signs they do not hide it."""
    shares = np.array([[0.5, 0.5], [-0.04, 0.04], [0.5, -0.5], [-0.06, -0.04], [0.06, 0.04]])
    assert sign_changes(shares) == (2, 1)


def test_a_smooth_motion_turns_once_and_comes_back_with_its_visit(line) -> None:
    """With s = 10 u^3 - 15 u^4 + 6 u^5 every cart that moves brakes once, and never turns back."""
    powers = 3.0 ** np.array([5, 4, 3, 2, 1, 0])
    law = PPoly(np.array([6.0, -15.0, 10.0, 0.0, 0.0, 0.0])[:, None] / powers[:, None], [0.0, 3.0])
    quality = measure_quality(Trajectory(line(0.9), law, dwell_s=(1.0, 2.0)))
    assert quality.velocity_sign_changes == (0, 0, 0, 0, 0)
    assert quality.acceleration_sign_changes == (1, 1, 1, 0, 0)
    assert quality.motion_s == 3.0


def test_the_fraction_of_the_speed_changes_nothing(path) -> None:
    """A motion planned at a tenth of the speed has the quality that it has at full speed."""
    fastest = plan(path, 500)
    quality, slow = measure_quality(fastest), measure_quality(slowed(fastest, 0.1), 0.1)
    assert slow.velocity_sign_changes == quality.velocity_sign_changes
    assert slow.acceleration_sign_changes == quality.acceleration_sign_changes
    assert slow.motion_s == pytest.approx(quality.motion_s)


def test_a_path_back_to_its_start_has_no_ratio(path) -> None:
    """The goal is the start: no actuator has to move, and there is nothing to compare with."""
    quality = measure_quality(plan(path, 500))
    assert quality.least_time_s == 0.0
    assert quality.time_ratio is None
    assert all(count >= 1 for count in quality.velocity_sign_changes)
