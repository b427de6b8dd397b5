"""The trajectory as files."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.artifacts.results.path import path_files
from pipeline.artifacts.results.trajectory import load_trajectory, trajectory_files
from pipeline.config import Config
from pipeline.export import read_csv, sidecar
from pipeline.machine import Machine
from pipeline.refine.measure import sample_path
from pipeline.retime import measure_usage, sample_trajectory
from tests.artifacts.saved import SavedRun, put

Make = dict[str, Callable[..., Any]]


def test_it_comes_back(tmp_path: Path, fast_config: Config, machine: Machine, make: Make) -> None:
    """The trajectory comes back exactly, and its sidecar describes every column of its table."""
    refinement = make["refinement"](machine)
    trajectory = make["trajectory"](refinement.path)
    samples = sample_trajectory(trajectory, 0.01)
    usage = measure_usage(trajectory)
    put(tmp_path, trajectory_files(trajectory, samples, sidecar(fast_config, machine, samples, usage)))
    put(tmp_path, path_files(refinement, sample_path(refinement.path, np.linspace(0.0, 1.0, 11))))
    loaded = load_trajectory(SavedRun(tmp_path, machine))
    t = np.linspace(0.0, 2.0, 33)
    for derivative in range(3):
        assert np.array_equal(loaded.q(t, derivative), trajectory.q(t, derivative))
    columns = read_csv((tmp_path / "trajectory.csv").read_text())
    described = json.loads((tmp_path / "trajectory.json").read_text())["columns"]
    assert [column["name"] for column in described] == list(columns)
