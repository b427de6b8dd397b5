"""The coarse path."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.errors import NoSolutionError
from pipeline.machine import Machine
from pipeline.machine.kinematics import closure_residual
from pipeline.refine import Path, coarse_path
from pipeline.refine.coarse import corner_parameters, move_of
from pipeline.route import Route
from pipeline.route.metric import arc_length


def test_it_passes_through_every_step_of_the_route(coarse: Path, route: Route) -> None:
    """At its corners actuators and poses are the route's."""
    corners = corner_parameters(coarse)
    np.testing.assert_allclose(coarse.q(corners), route.q_m, atol=1e-12)
    np.testing.assert_allclose(coarse.pose(corners), route.pose, atol=1e-8)


def test_its_moves_are_straight_in_actuator_space(coarse: Path, route: Route) -> None:
    """Halfway along a move the actuators are halfway."""
    corners = corner_parameters(coarse)
    middle = coarse.q((corners[1:] + corners[:-1]) / 2.0)
    np.testing.assert_allclose(middle, (route.q_m[1:] + route.q_m[:-1]) / 2.0, atol=1e-12)


def test_its_nodes_close_all_links_and_do_not_jump(coarse: Path, machine: Machine) -> None:
    """Poses are known densely, on one branch."""
    assert np.abs(closure_residual(machine, coarse.node_pose, coarse.q(coarse.node_s))).max() < 1e-9
    assert np.abs(np.diff(coarse.node_pose, axis=0)).max() < 0.05


def test_corners_lie_at_their_share_of_the_arc_length(coarse: Path, steps: np.ndarray) -> None:
    """The parameter s of a corner is the length up to it."""
    length = arc_length(coarse.node_pose, steps)
    at_corners = np.interp(corner_parameters(coarse), coarse.node_s, length / length[-1])
    np.testing.assert_allclose(at_corners, corner_parameters(coarse), atol=1e-9)


def test_a_parameter_belongs_to_the_move_it_lies_in(coarse: Path, route: Route) -> None:
    """Inside a move it is that move's number, at the goal the last one's."""
    corners = corner_parameters(coarse)
    moves = np.arange(len(route) - 1)
    np.testing.assert_array_equal(move_of(coarse, (corners[1:] + corners[:-1]) / 2.0), moves)
    assert move_of(coarse, np.array([0.0, 1.0])).tolist() == [0, len(route) - 2]


@pytest.mark.parametrize("where", [[3], [-1], [0, 5, 5, -1]])
def test_a_step_where_the_one_before_is_changes_nothing(
    machine: Machine, route: Route, coarse: Path, steps: np.ndarray, where: list[int]
) -> None:
    """A visit may be made at a step of the route: both have one parameter, and the path is the same."""
    rows = np.sort(np.append(np.arange(len(route)), np.arange(len(route))[where]))
    fields = ("region", "modes", "gates", "visits", "pose", "q_m", "kappa")
    longer = replace(route, **{name: getattr(route, name)[rows] for name in fields})
    path = coarse_path(machine, longer, steps)
    np.testing.assert_allclose(path.spline.t, coarse.spline.t, atol=1e-12)
    np.testing.assert_allclose(corner_parameters(path), corner_parameters(coarse)[rows], atol=1e-12)
    s = np.linspace(0.0, 1.0, 200)
    np.testing.assert_allclose(path.q(s), coarse.q(s), atol=1e-12)
    np.testing.assert_allclose(path.pose(s), coarse.pose(s), atol=1e-8)
    assert set(move_of(path, s).tolist()) <= set(range(len(longer) - 1))


def test_a_route_that_cannot_be_followed_is_refused(machine: Machine, route: Route, steps: np.ndarray) -> None:
    """A step on another branch of the forward kinematics is named."""
    pose = route.pose.copy()
    pose[3, 4] += 1.0
    with pytest.raises(NoSolutionError, match="move 3"):
        coarse_path(machine, replace(route, pose=pose), steps)
