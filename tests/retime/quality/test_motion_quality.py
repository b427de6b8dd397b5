"""The quality of a motion: reversals that are known, and the planner's time on lines whose least time it is."""

import numpy as np
import pytest
from scipy.interpolate import PPoly

from pipeline.retime import Trajectory, measure_quality, slowed
from pipeline.retime.fastest import plan
from pipeline.retime.quality.least_time import rest_to_rest_s
from pipeline.retime.quality.motion_quality import sign_changes


def test_the_planner_finds_the_same_time(line) -> None:
    """Along a line of one actuator's own, the fastest law takes the least time; a metre, and a centimetre."""
    for travel_m in (0.9, 0.01):
        trajectory = plan(line(travel_m), 1_000)
        quality = measure_quality(trajectory)
        assert quality.time_ratio == pytest.approx(1.0, abs=1e-3)
        assert quality.least_times_s[:3] == pytest.approx([rest_to_rest_s(travel_m, 0.5, 2.0)] * 3)
        assert quality.least_times_s[3:] == (0.0, 0.0)


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
