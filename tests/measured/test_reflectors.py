"""Where reflectors on the platform are in space."""

import numpy as np
import pytest

from pipeline.errors import UsageError
from pipeline.machine import Machine, inverse_kinematics
from pipeline.machine.geometry import platform_arms
from pipeline.measured import Reflectors, reflector_positions


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


@pytest.mark.parametrize(
    ("points", "noise_m", "expected"),
    [
        ([[np.nan, 0.0, 0.0], [0.0, 0.4, 0.0]], 1e-4, r"reflector 1 is at \(nan, 0, 0\)"),
        ([[0.0, 0.1, 0.0], [0.0, np.inf, 0.0]], 1e-4, r"reflector 2 is at \(0, inf, 0\)"),
        ([[0.0, 0.1, 0.0], [0.0, 400.0, 0.0]], 1e-4, r"reflector 2 .*\n.*look like millimetres"),
        ([0.0, 0.1, 0.0], 1e-4, "three coordinates"),
        ([["a", "b", "c"]] * 2, 1e-4, "three coordinates"),
        ([[0.0, 0.1, 0.0], [0.0, 0.4, 0.0]], -1e-4, "noise"),
        ([[0.0, 0.1, 0.0], [0.0, 0.4, 0.0]], np.nan, "noise"),
        ([[0.0, 0.1, 0.0], [0.0, 0.4, 0.0]], 1e-320, "noise"),
    ],
)
def test_reflectors_are_where_they_can_be(points: object, noise_m: float, expected: str) -> None:
    """Places that are not finite or not in metres, and noise that is none, are refused."""
    with pytest.raises(UsageError, match=expected):
        Reflectors(np.array(points), noise_m)
