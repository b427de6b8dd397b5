"""Sampled errors of the tool: corners that are climbed to are worse than random ones."""

import numpy as np

from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine import Machine
from pipeline.machine.kinematics import newton
from pipeline.pose_error import sample_pose_error
from pipeline.pose_error.samples import rotation_angle
from pipeline.refine import Path


def test_no_error_within_the_limits_is_worse_to_first_order(machine: Machine, line: Path) -> None:
    """Neither of position nor of rotation, where lengths are off as well as drives."""
    errors, s = Uncertainty(2e-5, 0.0, (1e-4,) * 5), np.array([0.0, 0.4, 1.0])
    found = sample_pose_error(line, errors, s, draws=0)
    random = np.random.default_rng(2)
    for _ in range(100):
        pose, _ = newton(machine, line.q(s) + random.choice([-1e-4, 1e-4], (3, 5)), line.pose(s))
        assert (np.linalg.norm(pose[:, :3] - line.pose(s)[:, :3], axis=1) <= found.position_m).all()


def test_angles_are_those_between_orientations() -> None:
    """Small and large ones, about any axis."""
    turned = np.zeros((3, 6))
    turned[:, 3] = [1e-9, 0.3, 3.0]
    np.testing.assert_allclose(rotation_angle(np.zeros((3, 6)), turned), turned[:, 3], rtol=1e-6)
