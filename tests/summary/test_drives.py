"""What the drives feel, in the summary."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from pipeline.machine import Machine, inverse_kinematics
from pipeline.machine.geometry import ACTUATORS
from pipeline.refine.result import Path
from pipeline.retime import Trajectory, measure_drives
from pipeline.retime.fastest import plan
from pipeline.summary.drives import drives_part


@pytest.fixture(scope="module")
def trajectory(machine: Machine) -> Trajectory:
    """A motion across the workspace, timed."""
    s = np.linspace(0.0, 1.0, 12)
    controlled = np.outer(1.0 - s, [1.02, 0.3, 0.9, 0.0, 0.0]) + np.outer(s, [1.1, 0.6, 0.8, -0.1, 0.2])
    solution = inverse_kinematics(machine, controlled, np.zeros(12, dtype=np.int64))
    return plan(Path(machine, make_interp_spline(s, solution.q_m, k=5), s, solution.pose), 200)


def test_extremes_come_with_place_and_direction(trajectory: Trajectory) -> None:
    """Values are those of the figures at the time that is stated, along unit vectors whose largest part is positive."""
    drives = measure_drives(trajectory)
    section = drives_part(drives, ACTUATORS)["drives"]
    felt = drives.felt
    assert felt is not None
    for key, figure in (
        ("reflected_mass_worst_kg", felt.worst_mass_kg),
        ("stiffness_least_npm", felt.stiffness_npm),
        ("damping_least_nspm", felt.damping_nspm),
    ):
        found = section[key]
        row = int(np.abs(drives.t_s - found["t_s"]).argmin())
        assert found["value"] == figure.value[row] == (figure.value.max() if "worst" in key else figure.value.min())
        assert found["s"] == drives.s[row]
        assert np.linalg.norm(found["along"]) == pytest.approx(1.0)
        assert max(found["along"]) == max(map(abs, found["along"]))
    for column, name in zip(felt.reflected_mass_kg.T, ACTUATORS, strict=True):
        masses = section["reflected_mass_kg"][name]
        assert (masses["least"], masses["largest"]) == (column.min(), column.max())
    gains = section["amplification_max"]
    assert gains["mm_per_mm"]["value"] == drives.amplified.position.value.max()
    assert gains["mrad_per_mm"]["by_drive"] == drives.amplified.angle_by_drive.max(axis=0).tolist()


def test_without_masses_the_rest_is_skipped(trajectory: Trajectory) -> None:
    """Amplification needs no masses."""
    path = replace(trajectory.path, machine=replace(trajectory.path.machine, masses=None))
    section = drives_part(measure_drives(replace(trajectory, path=path)), ACTUATORS)["drives"]
    assert section["reflected_mass_kg"] == section["stiffness_least_npm"] == "skipped"
    assert section["amplification_max"]["mm_per_mm"]["value"] > 0.0
