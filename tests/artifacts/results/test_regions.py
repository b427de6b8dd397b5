"""The region table as a file."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pipeline.artifacts.npz import read_npz
from pipeline.artifacts.results.regions import load_regions, regions_files
from pipeline.config import Config
from pipeline.machine import Machine
from tests.artifacts.saved import SavedRun, put, same

Make = dict[str, Callable[..., Any]]


def test_regions(tmp_path: Path, machine: Machine, make: Make, quick_config: Config) -> None:
    """The region table comes back to the last bit, from one array per column."""
    table = make["regions"](machine, 50)
    put(tmp_path, regions_files(table))
    assert same(load_regions(SavedRun(tmp_path, machine, quick_config)), table)
    arrays = read_npz(tmp_path / "regions.npz")
    assert {array.shape for array in arrays.values()} == {(50,)}
    assert {"x_m", "rz_rad", "ry_rad", "mode", "gate", "q5_m", "kappa", "x_max_m"} <= set(arrays)
