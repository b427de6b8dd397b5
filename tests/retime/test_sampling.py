"""Samples at an exact period: from rest to rest, within limits, consistent with one another."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.config import Config
from pipeline.machine import condition_number, statics_matrix
from pipeline.machine.kinematics import closure_residual
from pipeline.refine.result import Path
from pipeline.retime import Trajectory, measure_usage, retime_path, sample_trajectory, stretched
from pipeline.retime.sampling import whole_periods


@pytest.fixture(scope="module")
def trajectory(agder_config: Config, path: Path) -> Trajectory:
    """The curve in time, a whole number of periods long."""
    return retime_path(agder_config, path)


@pytest.mark.parametrize("period_s", [0.1, 0.01, 0.007, 0.001])
def test_rows_are_a_period_apart_and_end_at_the_goal_at_rest(trajectory: Trajectory, period_s: float) -> None:
    """Row k is at k periods; the ends are those of the path, to the last bit, without velocity."""
    samples = sample_trajectory(trajectory, period_s)
    assert np.array_equal(samples.t_s, period_s * np.arange(len(samples)))
    assert samples.period_s == period_s
    assert samples.duration_s == samples.t_s[-1] >= trajectory.duration_s * (1.0 - 1e-12)
    assert samples.duration_s < trajectory.duration_s + period_s
    assert np.array_equal(samples.q_m[[0, -1]], trajectory.path.q(np.array([0.0, 1.0])))
    assert np.all(samples.qd_mps[[0, -1]] == 0.0)
    assert np.all(samples.qdd_mps2[-1] == 0.0)


def test_the_period_of_the_run_needs_no_further_stretch(agder_config: Config, trajectory: Trajectory) -> None:
    """What is verified and reported is what is sampled: the same trajectory, not a stretched copy."""
    period = agder_config.retime.period_s
    assert whole_periods(trajectory, period) is trajectory
    samples = sample_trajectory(trajectory, period)
    assert samples.duration_s == trajectory.duration_s
    assert np.array_equal(samples.qdd_mps2, trajectory.q(samples.t_s, 2))


@settings(max_examples=50)
@given(duration_s=st.floats(0.02, 60.0), period_s=st.sampled_from([0.000125, 0.001, 0.004, 0.01, 0.03, 0.1]))
def test_the_last_row_is_the_goal_whatever_the_duration(
    trajectory: Trajectory, duration_s: float, period_s: float
) -> None:
    """Stretching to whole periods is idempotent, adds less than a period and never shortens noticeably."""
    once = whole_periods(stretched(trajectory, duration_s), period_s)
    assert whole_periods(once, period_s) is once
    assert duration_s * (1.0 - 1e-7) <= once.duration_s < duration_s + period_s
    assert once.duration_s == round(once.duration_s / period_s) * period_s


def test_a_motion_shorter_than_a_period_takes_one(trajectory: Trajectory) -> None:
    """There are always two rows, the start and the goal."""
    samples = sample_trajectory(stretched(trajectory, 1e-4), 0.01)
    assert len(samples) == 2
    assert samples.duration_s == 0.01


def test_limits_hold_for_every_period(trajectory: Trajectory) -> None:
    """Time is only ever stretched, so no limit is exceeded at another period either."""
    machine = trajectory.path.machine
    for period_s in (0.003, 0.01, 0.05):
        samples = sample_trajectory(trajectory, period_s)
        assert np.all(np.abs(samples.qd_mps) <= machine.velocity_mps * (1.0 + 1e-9))
        assert np.all(np.abs(samples.qdd_mps2) <= machine.acceleration_mps2 * (1.0 + 1e-9))
        assert measure_usage(whole_periods(trajectory, period_s)).largest <= 1.0 + 1e-9


def test_differencing_rows_agrees_with_the_columns(trajectory: Trajectory) -> None:
    """At 1 ms, but for the rows beside a jump, second differences of q are qdd; none shows more than the limit."""
    samples = sample_trajectory(trajectory, 0.001)
    limits = trajectory.path.machine.acceleration_mps2
    second = np.diff(samples.q_m, 2, axis=0) / samples.period_s**2
    error = np.abs(second - samples.qdd_mps2[1:-1]) / limits
    assert np.mean(error.max(axis=1) > 0.01) < 0.02
    assert np.median(error) < 1e-4
    assert np.abs(second / limits).max() <= 1.0
    first = (samples.q_m[2:] - samples.q_m[:-2]) / (2.0 * samples.period_s)
    assert first == pytest.approx(samples.qd_mps[1:-1], abs=1e-3)


def test_poses_and_kappa_belong_to_the_actuators(trajectory: Trajectory) -> None:
    """The pose closes all links, and kappa is that of the pose."""
    samples = sample_trajectory(trajectory, 0.02)
    machine = trajectory.path.machine
    assert np.abs(closure_residual(machine, samples.pose, samples.q_m)).max() < 1e-10
    assert np.array_equal(samples.kappa, condition_number(statics_matrix(machine, samples.pose, samples.q_m[:, :3])))
    assert len(samples) == len(samples.pose) == len(samples.kappa)
