"""`certify --check` on the error of the tool that a run states."""

import pathlib
import shutil

import numpy as np
import pytest

from pipeline.artifacts.results.pose_error import pose_error_files, uncertainty_of
from pipeline.certify import certify_path
from pipeline.certify.recheck.pose_error import INTERVALS, POSITION
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.pose_error import bound_pose_error
from tests.certify.paths import START, pose_path
from tests.certify.runs import check, write_run
from tests.certify.test_check import refused
from tests.run.conftest import changed


@pytest.fixture(scope="module")
def proven_run(
    tmp_path_factory: pytest.TempPathFactory, own_task: Config, machine: Machine, goal: np.ndarray
) -> pathlib.Path:
    """Certify a short path with the error of its tool, and write it as a run does."""
    config = changed(own_task, certify__pose_error={"drives_m": [1e-4] * 5})
    assert config.certify.pose_error is not None
    path = pose_path(machine, np.linspace(START, goal, 11), 0, 11)
    folder = tmp_path_factory.mktemp("tool") / "true"
    write_run(folder, config, path, certify_path(config, machine, path))
    for name, content in pose_error_files(bound_pose_error(path, uncertainty_of(config.certify.pose_error))).items():
        (folder / name).write_bytes(content)
    return folder


@pytest.fixture
def tool_run(proven_run: pathlib.Path, tmp_path: pathlib.Path) -> pathlib.Path:
    """Give a copy, to be forged."""
    return pathlib.Path(shutil.copytree(proven_run, tmp_path / "run"))


def test_it_is_verified(tool_run: pathlib.Path) -> None:
    """With what was found beside what is stated."""
    result = check(tool_run)
    assert result.exit_code == 0, result.output
    assert POSITION in result.stdout


def test_a_table_that_states_less_is_refused(tool_run: pathlib.Path) -> None:
    """In a single row."""
    file = tool_run / "pose_error.csv"
    lines = file.read_text().splitlines()
    cells = lines[40].split(",")
    cells[2] = f"{0.98 * float(cells[2]):.12f}"
    lines[40] = ",".join(cells)
    file.write_text("\n".join(lines) + "\n")
    assert any(POSITION in claim for claim in refused(check(tool_run)))


def test_a_table_of_other_intervals_is_refused(tool_run: pathlib.Path) -> None:
    """Every bound is right, but the largest ones stand where the tool is off less."""
    file = tool_run / "pose_error.csv"
    header, *lines = file.read_text().splitlines()
    moved = ",".join([lines[40].split(",")[0], lines[41].split(",")[1], *lines[40].split(",")[2:]])
    file.write_text("\n".join([header, *lines[:40], moved, *lines[41:]]) + "\n")
    assert any(INTERVALS in claim for claim in refused(check(tool_run)))


@pytest.mark.parametrize("name", ["pose_error.npz", "pose_error.csv"])
def test_what_is_missing_or_damaged_is_named(tool_run: pathlib.Path, name: str) -> None:
    """Without its boxes or its table nothing is proven of the tool."""
    (tool_run / name).write_bytes(b"mine")
    damaged = check(tool_run)
    assert damaged.exit_code == 2
    assert name in damaged.stderr.replace("\n", "")
    (tool_run / name).unlink()
    missing = check(tool_run)
    assert missing.exit_code == 1
    assert f"{name} is missing" in missing.stdout
