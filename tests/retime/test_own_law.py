"""Paths that come with their time law."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config, RetimeConfig
from pipeline.refine import Path
from pipeline.refine.timed.first_motion import first_clock, fit_motion
from pipeline.refine.timed.hull import least_motion_s
from pipeline.retime import Trajectory, measure_usage, retime_path, way_back
from pipeline.retime.own_law import own_time_law


@pytest.fixture(scope="module")
def timed(path: Path) -> Path:
    """Drive the path of thirty coefficients from rest to rest, within all limits of its actuators."""
    clock = first_clock(path, 30)
    spline = fit_motion(path, clock, 30)
    tau = np.linspace(0.0, 1.0, 121)
    motion_s = least_motion_s(path.machine, spline)
    return Path(path.machine, spline, tau, path.pose(clock.s_at(tau)), motion_s=motion_s)


@pytest.fixture(scope="module")
def config(agder_config: Config) -> Config:
    """Take few pieces of jerk."""
    return agder_config.model_copy(update={"retime": RetimeConfig(jerk_pieces=100)})


@pytest.fixture(scope="module")
def there(config: Config, timed: Path) -> Trajectory:
    """Time it at full speed."""
    return retime_path(config, timed)


def test_time_runs_evenly_along_the_path(timed: Path) -> None:
    """At t the actuators are at q(t / T), with its derivatives divided by powers of T; jerk does not jump."""
    assert timed.motion_s is not None
    trajectory = own_time_law(timed, timed.motion_s)
    t = np.linspace(0.0, timed.motion_s, 57)[:-1]
    for order in range(4):
        expected = timed.q(t / timed.motion_s, order) / timed.motion_s**order
        np.testing.assert_allclose(trajectory.q(t, order), expected, atol=1e-9, rtol=1e-9)
    assert not trajectory.jerk_jumps


def test_it_is_kept_or_shortened_within_all_limits(config: Config, timed: Path, there: Trajectory) -> None:
    """The trajectory is no slower than the path's own time law, there and back, but for whole periods."""
    assert timed.motion_s is not None
    assert there.timing is not None
    assert there.timing.motion_s <= timed.motion_s * (1.0 + 1e-9)
    back = way_back(config, there)
    for trajectory in (there, back):
        assert measure_usage(trajectory, config.retime.period_s).largest <= 1.001
        assert trajectory.motion_s <= timed.motion_s + 0.01
        assert np.abs(trajectory.q(np.array([0.0, trajectory.motion_s]), 2)).max() < 1e-6


def test_without_jerk_limits_the_time_law_stays(config: Config, timed: Path) -> None:
    """Jerk is not held, as along other paths: it is only reported, and a law that exceeds it is not stretched."""
    config = config.model_copy(update={"retime": config.retime.model_copy(update={"jerk": False})})
    assert timed.motion_s is not None
    hasty = replace(timed, machine=replace(timed.machine, jerk_mps3=timed.machine.jerk_mps3 / 100.0))
    trajectory = retime_path(config, hasty)
    assert trajectory.jerk_jumps
    assert trajectory.timing is not None
    assert not trajectory.timing.jerk_limited
    assert trajectory.timing.motion_s == pytest.approx(timed.motion_s, rel=1e-3)


def test_limits_of_the_tcp_slow_it_down(config: Config, timed: Path, there: Trajectory) -> None:
    """What the path was not planned for is kept by its time law."""
    slow = replace(timed, machine=replace(timed.machine, tcp_speed_mps=0.1))
    trajectory = retime_path(config, slow)
    assert measure_usage(trajectory, config.retime.period_s).fractions["tcp_speed"].max() <= 1.001
    assert trajectory.motion_s > there.motion_s


def test_a_fraction_of_the_speed_takes_longer(config: Config, timed: Path, there: Trajectory) -> None:
    """Both ways take 1 / speed times as long."""
    half = config.model_copy(update={"retime": config.retime.model_copy(update={"speed": 0.5})})
    slow = retime_path(half, timed)
    assert slow.motion_s == pytest.approx(2.0 * there.motion_s, abs=0.03)
    assert way_back(half, slow).motion_s == pytest.approx(slow.motion_s, abs=0.03)
