"""Where the points of bodies are: against joints, rotations, and the same in CasADi."""

import numpy as np
import pytest

from pipeline.machine import Machine
from pipeline.machine.bodies.placement import Frames
from pipeline.machine.bodies.symbolic import hull_function
from pipeline.machine.drawing import drawn_points
from pipeline.machine.shapes.model import FrameKind, SweptHull


@pytest.fixture(scope="module")
def placed(ends_machine: Machine, draw_poses):
    """Draw poses, and place the frames there."""
    drawn = draw_poses(ends_machine, 3, 60)
    return drawn, Frames.of(ends_machine, drawn.pose, drawn.q_m[:, :3])


def test_platform_points_are_where_joints_are(ends_machine: Machine, placed) -> None:
    """A hull of the joints themselves."""
    drawn, frames = placed
    hull = SweptHull("joints", FrameKind.PLATFORM, 0, ends_machine.platform_points_m, 0.0)
    expected = drawn_points(ends_machine, drawn.pose, drawn.q_m).platform_joints_m
    np.testing.assert_allclose(np.moveaxis(frames.points(hull), -1, 0), expected, atol=1e-12)


def test_link_points_are_metres_from_either_joint(ends_machine: Machine, placed) -> None:
    """Cut short by 12 cm at the cart and 8 cm at the platform, on the line between the joints."""
    drawn, frames = placed
    ends = drawn_points(ends_machine, drawn.pose, drawn.q_m)
    for link in range(6):
        hull = SweptHull("link", FrameKind.LINK, link, np.array([[0.0, 0.12], [1.0, -0.08]]), 0.0)
        first, last = np.moveaxis(frames.points(hull), -1, 1)
        C, A = ends.cart_joints_m[:, link], ends.platform_joints_m[:, link]
        np.testing.assert_allclose(np.linalg.norm(first - C, axis=1), 0.12)
        np.testing.assert_allclose(np.linalg.norm(last - A, axis=1), 0.08)
        np.testing.assert_allclose(np.cross(first - C, A - C), 0.0, atol=1e-12)


def test_cart_points_slide_along_their_rail(ends_machine: Machine, placed) -> None:
    """From the point of the rail that the cart is at."""
    drawn, frames = placed
    for arm in range(3):
        points = frames.points(SweptHull("cart", FrameKind.CART, arm, np.array([[0.1, 0.2, 0.3]]), 0.0))[0].T
        expected = np.column_stack([drawn.q_m[:, arm], *np.tile(ends_machine.rails_m[arm], (len(points), 1)).T])
        np.testing.assert_allclose(points, expected + [0.1, 0.2, 0.3])


def test_casadi_places_every_hull_alike(ends_machine: Machine, placed) -> None:
    """One function per hull, of pose and actuators."""
    drawn, frames = placed
    assert ends_machine.bodies is not None
    for hull in ends_machine.bodies.hulls:
        function, points = hull_function(ends_machine, hull), frames.points(hull)
        for k in range(0, 60, 20):
            if k < len(drawn.pose):
                np.testing.assert_allclose(np.array(function(drawn.pose[k], drawn.q_m[k])), points[..., k], atol=1e-12)
