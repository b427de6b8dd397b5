"""A tour of four poses that costs next to nothing: real regions and moves, made-up legs."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pipeline.atlas.graph import AtlasGraph, build_graph
from pipeline.atlas.stations import Station
from pipeline.calibrate import NextPoses
from pipeline.calibrate.report import next_columns
from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.export.csv import format_csv
from pipeline.machine import MODES, build_machine, inverse_kinematics
from pipeline.route import grid_regions
from pipeline.run.tour import read_stops
from tests.conftest import CONFIGS
from tests.run.conftest import *  # noqa: F403  # fixtures are found by their names here

MODES_OF = ["RRR", "LLL", "LLL", "LLL"]
CONTROLLED = np.array(
    [
        [1.02, 0.3, 0.9, 0.0, 0.0],
        [1.02, 0.45, 0.6, 0.0, 0.1],
        [1.0, 0.35, 0.8, 0.05, 0.0],
        [1.1, 0.4, 0.75, 0.0, 0.0],
    ]
)
"""x, y, z, rx, rz of four poses that the smallest grid joins."""


@pytest.fixture(scope="session")
def cell() -> Config:
    """Load the smallest configuration."""
    return load_config(CONFIGS / "tiny.yaml")


@pytest.fixture(scope="session")
def poses_file(cell: Config, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a table of four poses to measure, as `calibrate` does."""
    file = tmp_path_factory.mktemp("poses") / "first.csv"
    modes = np.array([MODES.index(mode) for mode in MODES_OF])
    there = inverse_kinematics(build_machine(cell.machine), CONTROLLED, modes)
    proposed = NextPoses(there.q_m, there.pose, MODES_OF, np.ones(4), np.ones(5))
    file.write_text(format_csv(next_columns(proposed, 2)))
    return file


@pytest.fixture(scope="session")
def graph(cell: Config, poses_file: Path) -> AtlasGraph:
    """Join the start and the four poses to the grid."""
    machine = build_machine(cell.machine)
    home = Station("start", cell.task.start, "task.start")
    stations = (home, *read_stops(poses_file, cell).stations)
    return build_graph(cell, machine, stations, grid_regions(cell, machine))


@pytest.fixture
def changed_poses(poses_file: Path, tmp_path: Path) -> Callable[[int, str, str], Path]:
    """Give a function that writes the table with another value in a row."""

    def change(row: int, column: str, value: str) -> Path:
        lines = [line.split(",") for line in poses_file.read_text().splitlines()]
        lines[row][lines[0].index(column)] = value
        file = tmp_path / "changed.csv"
        file.write_text("\n".join(",".join(cells) for cells in lines) + "\n")
        return file

    return change
