"""What is drawn of a machine: joints are where the kinematics puts them."""

import numpy as np

from pipeline.machine import Machine
from pipeline.machine.drawing import drawn_points, platform_corners, platform_faces, rail_ends
from pipeline.machine.geometry import link_lengths, rotation


def test_links_are_drawn_with_their_lengths(machine: Machine, draw_poses) -> None:
    """The distance between both ends of a link is its length, a telescope's its actuator, at any number of poses."""
    sample = draw_poses(machine, 3)
    points = drawn_points(machine, sample.pose, sample.q_m)
    drawn = np.linalg.norm(points.platform_joints_m - points.cart_joints_m, axis=-1)
    np.testing.assert_allclose(drawn, link_lengths(machine, sample.q_m[:, 3:]), atol=1e-9)
    one = drawn_points(machine, sample.pose[0], sample.q_m[0])
    np.testing.assert_array_equal(one.feet_m, points.feet_m[0])
    np.testing.assert_allclose(one.platform_joints_m, points.platform_joints_m[0], atol=1e-12)


def test_carts_are_on_their_rails(machine: Machine, draw_poses) -> None:
    """Feet have the y and z of their rail, and the x of their actuator; rails end where travel does."""
    sample = draw_poses(machine, 4)
    feet = drawn_points(machine, sample.pose, sample.q_m).feet_m
    np.testing.assert_array_equal(feet[..., 0], sample.q_m[:, :3])
    np.testing.assert_array_equal(rail_ends(machine)[:, :, 0], machine.travel_m)
    np.testing.assert_array_equal(rail_ends(machine)[:, 0, 1:], machine.rails_m)
    np.testing.assert_array_equal(feet[0, :, 1:], machine.rails_m)


def test_the_platform_is_a_hull_of_its_joints(machine: Machine, draw_poses) -> None:
    """Its corners, turned and moved with the pose, are TCP and joints; every joint is a corner of some face."""
    sample = draw_poses(machine, 5)
    pose = sample.pose[0]
    placed = pose[:3] + platform_corners(machine) @ rotation(*pose[3:]).T
    np.testing.assert_allclose(placed[0], pose[:3])
    np.testing.assert_allclose(placed[1:], drawn_points(machine, pose, sample.q_m[0]).platform_joints_m, atol=1e-12)
    faces = platform_faces(machine)
    assert faces.shape[1] == 3
    assert faces.min() >= 0
    assert faces.max() <= 6
