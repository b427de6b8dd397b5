"""Results whose files are damaged, swapped or made up: each is refused with its name."""

import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pipeline.artifacts.npz import npz_bytes
from pipeline.artifacts.results.path import load_path, load_refinement, path_files
from pipeline.artifacts.results.regions import load_regions, regions_files
from pipeline.artifacts.results.route import load_route, route_files
from pipeline.artifacts.results.trajectory import load_trajectory, pack_trajectory
from pipeline.config import Config
from pipeline.errors import PipelineError
from pipeline.machine import Machine
from pipeline.refine.measure import sample_path
from tests.artifacts.saved import SavedRun, put
from tests.cli.bad_inputs.arrays import DAMAGES
from tests.fuzzing import fuzz

LOADERS: dict[str, Callable[[SavedRun], Any]] = {
    "regions.npz": load_regions,
    "route.npz": load_route,
    "path.npz": load_refinement,
    "trajectory.npz": load_trajectory,
}
HARMLESS = {(name, damage) for name in ("regions.npz", "route.npz") for damage in ("half the rows", "backwards")}
"""Fewer rows, or rows in another order, are still a table; whether it is the right one, hashes tell."""


@pytest.fixture
def run(tmp_path: Path, machine: Machine, quick_config: Config, make: dict[str, Callable[..., Any]]) -> SavedRun:
    """Write a result of each stage that has arrays."""
    refinement = make["refinement"](machine)
    put(tmp_path, regions_files(make["regions"](machine)))
    put(tmp_path, route_files(make["route"](machine)))
    put(tmp_path, path_files(refinement, sample_path(refinement.path, np.linspace(0.0, 1.0, 11))))
    put(tmp_path, {"trajectory.npz": npz_bytes(pack_trajectory(make["trajectory"](refinement.path)))})
    return SavedRun(tmp_path, machine, quick_config)


def test_undamaged_files_are_read(run: SavedRun) -> None:
    """What the tests below damage is fine before."""
    for load in LOADERS.values():
        load(run)


@pytest.mark.parametrize("name", LOADERS)
@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_files_are_refused(run: SavedRun, name: str, damage: str) -> None:
    """Nothing but the error for users comes out, and it names the file."""
    file = run.folder / name
    file.write_bytes(DAMAGES[damage](file.read_bytes()))
    if (name, damage) in HARMLESS:
        assert LOADERS[name](run) is not None
        return
    with pytest.raises(PipelineError, match=name) as caught:
        LOADERS[name](run)
    assert len(str(caught.value)) < 1_000


@pytest.mark.parametrize(("name", "other"), [(a, b) for a in LOADERS for b in LOADERS if a != b])
def test_files_of_other_stages_are_refused(run: SavedRun, name: str, other: str) -> None:
    """A file in the place of another one is none of its kind."""
    (run.folder / name).write_bytes((run.folder / other).read_bytes())
    with pytest.raises(PipelineError, match=name):
        LOADERS[name](run)


@pytest.mark.parametrize("name", LOADERS)
def test_folders_and_missing_files_are_errors_of_the_system(run: SavedRun, name: str) -> None:
    """The command line reports these with the file's name, too."""
    (run.folder / name).unlink()
    with pytest.raises(FileNotFoundError):
        LOADERS[name](run)
    (run.folder / name).mkdir()
    with pytest.raises(IsADirectoryError):
        LOADERS[name](run)


def test_a_file_larger_than_allowed_is_not_read(run: SavedRun, vary: Callable[..., Config]) -> None:
    """Regions are bounded by what stage one may take up."""
    run.config = vary(run.config, {"route.memory_gb": 1e-7})
    with pytest.raises(OSError, match="at most 100 are read"):
        load_regions(run)


_VALUES = st.sampled_from([0, -1, 1, 7, 1e300, -1e300, np.nan, np.inf, 0.5, 10**15, 2**63 - 1, "text", True, 1j])


@fuzz(60)
@given(data=st.data())
def test_any_value_in_any_array_is_read_or_refused(run: SavedRun, data: st.DataObject) -> None:
    """Each array in turn is replaced by another number, shape or kind."""
    name = data.draw(st.sampled_from(list(LOADERS)))
    file = run.folder / name
    original = file.read_bytes()
    with np.load(io.BytesIO(original)) as stored:
        arrays: dict[str, Any] = dict(stored)
    key = data.draw(st.sampled_from(list(arrays)))
    shape = data.draw(st.one_of(st.just(arrays[key].shape), st.lists(st.integers(0, 4), max_size=3).map(tuple)))
    arrays[key] = np.full(shape, data.draw(_VALUES))
    file.write_bytes(npz_bytes(arrays))
    try:
        LOADERS[name](run)
    except PipelineError as error:
        assert name in str(error)
    finally:
        file.write_bytes(original)


@fuzz(100)
@given(place=st.integers(0, 10**6), byte=st.integers(0, 255), length=st.integers(1, 8))
@example(place=8, byte=255, length=8)
def test_any_bytes_in_a_file_are_read_or_refused(run: SavedRun, place: int, byte: int, length: int) -> None:
    """A few bytes of a path are overwritten."""
    content = bytearray((run.folder / "path.npz").read_bytes())
    at = place % len(content)
    content[at : at + length] = bytes([byte]) * len(content[at : at + length])
    (run.folder / "damaged.npz").write_bytes(content)
    try:
        load_path(run.folder / "damaged.npz", run.machine)
    except PipelineError as error:
        assert "damaged.npz" in str(error)


def test_a_bomb_takes_no_memory(tmp_path: Path, machine: Machine) -> None:
    """A small file that unpacks to a thousand times its size is refused by what it says of itself."""
    with zipfile.ZipFile(tmp_path / "path.npz", "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr("knots.npy", bytes(10**7))
    with pytest.raises(PipelineError, match="compressed"):
        load_path(tmp_path / "path.npz", machine)
