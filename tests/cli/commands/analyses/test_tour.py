"""The command of a tour."""

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from pipeline.config.file import load_config
from pipeline.export.csv import format_csv
from pipeline.export.trajectory_columns import POSE, POSITIONS
from pipeline.machine import MODES, build_machine, inverse_kinematics
from tests.conftest import CONFIGS


@pytest.fixture
def table() -> Path:
    """Write a configuration, and a table with a pose in reach and one that is not."""
    shutil.copy(CONFIGS / "tiny.yaml", "cell.yaml")
    machine = build_machine(load_config("cell.yaml").machine)
    controlled = np.array([[1.02, 0.45, 0.6, 0.0, 0.1]] * 2)
    there = inverse_kinematics(machine, controlled, np.full(2, MODES.index("LLL")))
    columns = dict(zip(POSITIONS, there.q_m.T, strict=True)) | dict(zip(POSE, there.pose.T, strict=True))
    columns["z_m"] = np.array([3.0, 0.6])
    Path("first.csv").write_text(format_csv(columns))
    return Path("first.csv")


def test_a_tour_is_shown(call, table: Path) -> None:
    """A row per leg, the files, and what is left out; the same as JSON."""
    result = call("tour", "cell.yaml", table, "--dwell-s", 2)
    assert result.exit_code == 0, result.output
    assert "pose-2" in result.stdout
    assert "certified" in result.stdout
    assert "pose-1 is left out: it is out of reach" in result.stderr
    folder = Path("results/tiny-tour")
    assert f"{folder / 'tour.csv'}: 1 pose in" in result.stderr
    again = json.loads(call("tour", "cell.yaml", table, "--dwell-s", 2, "--json").stdout)
    assert again == json.loads((folder / "tour.json").read_text())
    assert len(list(csv.reader((folder / "poses.csv").open()))) == 2


def test_what_cannot_be_driven_is_refused(call, table: Path) -> None:
    """A table without poses, a folder with other files, and poses of which none is in reach."""
    Path("bad.csv").write_text("q1_m,q2_m\n1,2\n")
    assert call("tour", "cell.yaml", "bad.csv").exit_code == 2
    assert call("tour", "cell.yaml", table, "--out", ".").exit_code == 2
    Path("one.csv").write_text("\n".join(table.read_text().splitlines()[:2]) + "\n")
    result = call("tour", "cell.yaml", "one.csv")
    assert (result.exit_code, "none of 1 poses" in result.stderr) == (1, True)
