"""How far the tool moves and turns with each drive."""

import numpy as np

from pipeline.machine import Machine
from pipeline.machine.kinematics import newton
from pipeline.pose_error import amplify_drives
from pipeline.pose_error.samples import rotation_angle
from pipeline.refine import Path

_STEP_M = 1e-5


def test_it_agrees_with_finite_differences(machine: Machine, line: Path) -> None:
    """The largest of both ends and the middle of each interval, for position and rotation."""
    edges = np.linspace(0.0, 1.0, 6)
    found = amplify_drives(line, edges)
    s = np.linspace(0.0, 1.0, 11)
    pose, q = line.pose(s), line.q(s)
    for k, drive in enumerate(np.eye(5)):
        ahead, behind = (newton(machine, q + side * _STEP_M * drive, pose)[0] for side in (1.0, -1.0))
        moved = np.linalg.norm((ahead - behind)[:, :3], axis=1) / (2.0 * _STEP_M)
        turned = rotation_angle(behind, ahead) / (2.0 * _STEP_M)
        for values, expected in ((found.position, moved), (found.rotation_radpm, turned)):
            largest = [expected[2 * i : 2 * i + 3].max() for i in range(5)]
            np.testing.assert_allclose(values[:, k], largest, rtol=1e-5, atol=1e-6)
