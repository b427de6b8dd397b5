"""Trajectories: evaluation anywhere, rest at both ends, the chain rule, storing and stretching."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from pipeline.refine.result import Path
from pipeline.retime import Trajectory, stretched
from pipeline.retime.fastest import plan


@pytest.fixture(scope="module")
def trajectory(path: Path) -> Trajectory:
    """The fastest law along the curve, as planned."""
    return plan(path, 1_000)


def test_it_rests_at_the_start_and_at_the_goal(trajectory: Trajectory) -> None:
    """Before the beginning and from the end on the machine is exactly at the ends and does not move."""
    t = np.array([-1.0, trajectory.duration_s, trajectory.duration_s + 1.0])
    assert np.array_equal(trajectory.s(t), [0.0, 1.0, 1.0])
    assert np.array_equal(trajectory.q(t), trajectory.path.q(np.array([0.0, 1.0, 1.0])))
    assert np.all(trajectory.q(t, 1) == 0.0)
    assert np.all(trajectory.q(t, 2) == 0.0)
    assert np.all(trajectory.q(0.0, 1) == 0.0)
    assert np.abs(trajectory.q(0.0, 2)).max() > 0.0


def test_s_never_leaves_the_path_and_never_turns_back(trajectory: Trajectory) -> None:
    """s(t) ascends from 0 to 1, rounding at the breakpoints included."""
    t = np.sort(np.concatenate([trajectory.time_law.x, np.linspace(0.0, trajectory.duration_s, 20_001)]))
    s = trajectory.s(t)
    assert s.min() == 0.0
    assert s.max() == 1.0
    assert np.all(np.diff(s) >= 0.0)


def test_the_time_law_is_continuously_differentiable(trajectory: Trajectory) -> None:
    """At every breakpoint the piece before ends where, and as fast as, the piece after begins."""
    half, sd, s = trajectory.time_law.c
    dt = np.diff(trajectory.time_law.x)
    assert (s + sd * dt + half * dt**2)[:-1] == pytest.approx(s[1:], abs=1e-13)
    assert (sd + 2.0 * half * dt)[:-1] == pytest.approx(sd[1:], abs=1e-12)


def _inside_pieces(trajectory: Trajectory, reach: float) -> np.ndarray:
    """Instants in the middle of pieces that are longer than twice the reach of a difference quotient."""
    x = trajectory.time_law.x
    return ((x[1:] + x[:-1]) / 2.0)[np.diff(x) > 2.0 * reach]


def test_differencing_twice_gives_the_accelerations(trajectory: Trajectory) -> None:
    """Central differences of q(t) between breakpoints agree with qd and qdd."""
    h = 1e-3
    t = _inside_pieces(trajectory, h)
    assert len(t) > 500
    before, here, after = trajectory.q(t - h), trajectory.q(t), trajectory.q(t + h)
    assert (after - before) / (2.0 * h) == pytest.approx(trajectory.q(t, 1), abs=2e-5)
    assert (after - 2.0 * here + before) / h**2 == pytest.approx(trajectory.q(t, 2), abs=1e-3)


def test_accelerations_integrate_to_velocities_and_positions(trajectory: Trajectory) -> None:
    """Simpson's rule over every piece reproduces the changes of qd and q, jumps notwithstanding."""
    x = trajectory.time_law.x
    inner = 1e-9 * np.diff(x)[:, None]
    t = np.clip(x[:-1, None] + np.diff(x)[:, None] * np.array([0.0, 0.5, 1.0]), x[:-1, None], x[1:, None] - inner)
    weight = np.array([1.0, 4.0, 1.0])[:, None] / 6.0 * np.diff(x)[:, None, None]
    assert (trajectory.q(t, 2) * weight).sum(axis=1) == pytest.approx(np.diff(trajectory.q(x, 1), axis=0), abs=1e-7)
    assert (trajectory.q(t, 1) * weight).sum(axis=1) == pytest.approx(np.diff(trajectory.q(x), axis=0), abs=1e-9)


def test_poses_close_the_links_and_end_at_the_path_ends(trajectory: Trajectory) -> None:
    """The pose at a time is the path's pose at that s."""
    poses = trajectory.pose(np.array([0.0, 1.0, trajectory.duration_s]))
    s = trajectory.s(np.array([0.0, 1.0, trajectory.duration_s]))
    assert np.array_equal(poses, trajectory.path.pose(s))


def test_it_takes_scalars_and_arrays_of_any_shape(trajectory: Trajectory) -> None:
    """Shapes of t carry over, with the actuators as the last axis."""
    t = np.linspace(0.1, 1.0, 6).reshape(2, 3)
    for derivative in range(3):
        assert trajectory.q(0.5, derivative).shape == (5,)
        assert trajectory.q(t, derivative).shape == (2, 3, 5)
        assert np.array_equal(trajectory.q(t, derivative)[1, 2], trajectory.q(1.0, derivative))


def test_there_is_no_third_derivative(trajectory: Trajectory) -> None:
    """Where the acceleration jumps there is no jerk to evaluate."""
    with pytest.raises(ValueError, match="derivatives 0 to 2"):
        trajectory.q(0.5, 3)


def test_breakpoints_reproduce_it_exactly(trajectory: Trajectory) -> None:
    """Loading what was stored gives the same numbers to the last bit."""
    x, c = trajectory.time_law.x, trajectory.time_law.c
    again = Trajectory.from_breakpoints(
        trajectory.path, x, np.append(c[2], 1.0), np.append(c[1], 0.0), np.append(2.0 * c[0], 0.0)
    )
    assert np.array_equal(again.time_law.c, trajectory.time_law.c)
    assert np.array_equal(again.time_law.x, trajectory.time_law.x)


@given(factor=st.floats(0.1, 50.0))
def test_stretching_scales_velocities_and_accelerations(trajectory: Trajectory, factor: float) -> None:
    """In f times the time, velocities are divided by f and accelerations by f^2, at corresponding instants."""
    slow = stretched(trajectory, trajectory.duration_s * factor)
    assert slow.duration_s == trajectory.duration_s * factor
    t = _inside_pieces(trajectory, 0.0)
    assert_allclose(slow.s(t * factor), trajectory.s(t), atol=1e-12)
    assert_allclose(slow.q(t * factor, 1) * factor, trajectory.q(t, 1), atol=1e-11)
    assert_allclose(slow.q(t * factor, 2) * factor**2, trajectory.q(t, 2), atol=1e-9)


@pytest.mark.parametrize("duration_s", [0.0, -1.0, float("nan")])
def test_a_trajectory_needs_time(trajectory: Trajectory, duration_s: float) -> None:
    """A duration that is not positive is refused."""
    with pytest.raises(ValueError, match="cannot last"):
        stretched(trajectory, duration_s)


def test_the_planner_is_loaded_only_to_plan() -> None:
    """Loading and evaluating trajectories works without solvers and plotting libraries."""
    solver = "pipeline.retime.jerk.solve"
    script = f"import pipeline.retime, sys; sys.exit('{solver}' in sys.modules or 'matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0
