"""A path and the machine's dynamics along it: interpolated as evaluated, and friction opposing the motion."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.errors import ForwardKinematicsError
from pipeline.refine.result import Path
from pipeline.retime.path_dynamics import evaluate_dynamics, grid, tabulate_dynamics
from pipeline.retime.quantities import at_rest, evaluate


@pytest.fixture(scope="module")
def tight(path: Path) -> Path:
    """The curve, with a limit of every kind."""
    return replace(path, machine=replace(path.machine, tcp_speed_mps=0.4, tcp_acceleration_mps2=1.0))


def test_a_table_gives_what_evaluating_gives(tight: Path) -> None:
    """Between the points of its grid, to seven digits of the largest."""
    s = np.sort(np.random.default_rng(0).uniform(0.0, 1.0, 200))
    table, exact = tabulate_dynamics(tight, grid(2_001)).at(s), evaluate_dynamics(tight, s)
    for name in ("q1", "q2", "q3", "tcp1", "tcp2", "a", "b", "c"):
        found, right = getattr(table, name), getattr(exact, name)
        assert np.abs(found - right).max() <= 1e-6 * np.abs(right).max()


def test_without_masses_and_tcp_limits_no_pose_is_needed(path: Path) -> None:
    """Then there are no forces and nothing of the TCP, and the path need not close."""
    bare = replace(path, machine=replace(path.machine, masses=None), node_pose=path.node_pose + 50.0)
    with pytest.raises(ForwardKinematicsError):
        bare.pose(0.3)
    dynamics = tabulate_dynamics(bare, grid(51)).at(np.array([0.3]))
    assert set(evaluate(dynamics, *np.ones((3, 1)))) == {"velocity", "acceleration", "jerk"}


def test_friction_acts_against_the_motion_and_not_at_rest(path: Path) -> None:
    """Its force has the sign of q', and a machine at rest does not need it."""
    rubbing = replace(
        path, machine=replace(path.machine, masses=replace(path.machine.masses, friction_n=np.full(5, 20.0)))
    )
    s = np.linspace(0.05, 0.95, 7)
    with_it, without = evaluate_dynamics(rubbing, s), evaluate_dynamics(path, s)
    moving, still = np.full(7, 0.1), np.zeros(7)
    more = evaluate(with_it, moving, still, still)["force"] - evaluate(without, moving, still, still)["force"]
    assert more == pytest.approx(20.0 * np.sign(path.q(s, 1)))
    assert np.array_equal(
        evaluate(with_it, still, still, still)["force"], evaluate(without, still, still, still)["force"]
    )


def test_an_actuator_that_stands_still_has_no_friction(line) -> None:
    """Carts move together along X: what rounding leaves of the telescopes' q' has signs, and no friction."""
    path = line(0.5)
    masses = replace(path.machine.masses, friction_n=np.array([20.0, 20.0, 20.0, 50.0, 50.0]))
    dynamics = evaluate_dynamics(
        replace(path, machine=replace(path.machine, masses=masses)), np.linspace(0.0, 1.0, 400)
    )
    assert np.abs(dynamics.q1[:, 3:]).max() > 0.0
    assert np.all(dynamics.friction() == [20.0, 20.0, 20.0, 0.0, 0.0])
    gravity = dynamics.c[:, :5]
    assert at_rest(dynamics)["force"][:, 3:] == pytest.approx(gravity[:, 3:], abs=0.0)
