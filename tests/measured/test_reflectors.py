"""Where reflectors on the platform are in space."""

import numpy as np

from pipeline.machine import Machine, inverse_kinematics
from pipeline.machine.geometry import platform_arms
from pipeline.measured import reflector_positions


def test_without_rotation_they_are_shifted() -> None:
    """A platform that is not turned carries its reflectors along with the TCP."""
    points = np.array([[0.1, 0.2, 0.3], [0.0, 0.4, 0.0]])
    pose = np.array([[1.0, 2.0, 3.0, 0.0, 0.0, 0.0]])
    assert reflector_positions(points, pose).tolist() == [[[1.1, 2.2, 3.3], [1.0, 2.4, 3.0]]]


def test_a_reflector_on_a_joint_is_where_the_joint_is(machine: Machine) -> None:
    """Reflectors at platform joints 1 and 2b are found where the model has these joints, at any pose."""
    controlled = np.array([[1.0, 0.3, 0.9, 0.1, -0.2], [1.1, 0.4, 0.8, -0.2, 0.1]])
    pose = inverse_kinematics(machine, controlled, np.array([0, 7])).pose
    links = [0, 2]
    expected = pose[:, None, :3] + platform_arms(machine, pose)[:, links]
    assert np.allclose(reflector_positions(machine.platform_points_m[links], pose), expected, atol=1e-15)
