"""What is drawn of a machine: joints are where the kinematics puts them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree

from pipeline.machine import Machine
from pipeline.machine.clearance import segment_distance
from pipeline.machine.drawing import drawn_points, platform_bars, platform_corners, rail_ends
from pipeline.machine.geometry import link_lengths

MOTION = Path(__file__).parents[2] / "results" / "reference" / "agder" / "trajectory.csv"
POSE = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")


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


def test_bars_hold_the_platform_together(machine: Machine) -> None:
    """Six bars, the shortest that join the TCP and all joints."""
    corners, bars = platform_corners(machine), platform_bars(machine)
    lengths = np.linalg.norm(corners[:, None] - corners, axis=2)
    assert len(bars) == 6
    joined = coo_array((np.ones(6), bars.T), shape=(7, 7))
    assert connected_components(joined, directed=False)[0] == 1
    assert lengths[*bars.T].sum() == pytest.approx(minimum_spanning_tree(lengths).sum())


def test_joints_at_one_place_have_bars(machine: Machine) -> None:
    """Links that share a joint on the platform are held all the same."""
    points = machine.platform_points_m.copy()
    points[4] = points[3]
    bars = platform_bars(replace(machine, platform_points_m=points))
    assert connected_components(coo_array((np.ones(6), bars.T), shape=(7, 7)), directed=False)[0] == 1


def test_no_link_passes_through_a_bar(machine: Machine) -> None:
    """Along the reference motion no link, without its last 8 cm, comes nearer to a bar than 15 mm."""
    table = np.genfromtxt(MOTION, delimiter=",", names=True)
    pose, q = (np.stack([table[name] for name in names], axis=1) for names in (POSE, [f"q{k}_m" for k in range(1, 6)]))
    points = drawn_points(machine, pose, q)
    corners = np.concatenate([pose[:, None, :3], points.platform_joints_m], axis=1)
    vectors = points.platform_joints_m - points.cart_joints_m
    vectors *= 1.0 - 0.08 / np.linalg.norm(vectors, axis=2, keepdims=True)
    for a, b in platform_bars(machine):
        for link in range(6):
            distances = segment_distance(
                points.cart_joints_m[:, link], vectors[:, link], corners[:, a], corners[:, b] - corners[:, a]
            )
            assert distances.min() > 0.015
