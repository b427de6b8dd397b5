"""Result files: whole or not at all, exactly reloadable, never silently replaced."""

import io
import json
import math
import os
import subprocess
import sys
import textwrap
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure
from scipy.interpolate import BSpline

from pipeline.artifacts import (
    Record,
    State,
    existing_files,
    json_bytes,
    open_run_folder,
    plain,
    read_run_folder,
    read_state,
    sha256,
    sights,
    write_whole,
)
from pipeline.artifacts import files as files_module
from pipeline.artifacts.pack import npz_bytes, pack_refinement, read_npz
from pipeline.artifacts.path_file import load_path, save_path
from pipeline.artifacts.results import (
    failure_files,
    figure_files,
    load_refinement,
    load_regions,
    load_route,
    load_trajectory,
    path_files,
    regions_files,
    route_files,
    trajectory_files,
)
from pipeline.config import Config
from pipeline.config.file import config_sha256, dump_config
from pipeline.errors import UsageError
from pipeline.export import read_csv, sidecar
from pipeline.machine import Machine
from pipeline.refine.measure import sample_path
from pipeline.retime import measure_usage, sample_trajectory
from pipeline.stage import STAGES, Stage
from pipeline.status import Status

Make = dict[str, Callable[..., Any]]


def put(folder: Path, files: dict[str, bytes]) -> None:
    """Write files as they are."""
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


def same(a: object, b: object) -> bool:
    """Compare two results field by field, to the last bit."""
    for item in fields(a):
        left, right = getattr(a, item.name), getattr(b, item.name)
        if isinstance(left, np.ndarray):
            if left.dtype != right.dtype or not np.array_equal(left, right, equal_nan=left.dtype.kind == "f"):
                return False
        elif left != right or type(left) is not type(right):
            return False
    return True


class TestWriting:
    """Files appear whole or not at all."""

    def test_content_and_no_leftovers(self, tmp_path: Path) -> None:
        """A written file holds its content, and nothing else is left beside it."""
        write_whole(tmp_path / "a.txt", b"new")
        assert (tmp_path / "a.txt").read_bytes() == b"new"
        assert [entry.name for entry in tmp_path.iterdir()] == ["a.txt"]

    @pytest.mark.parametrize("moment", ["write_bytes", "replace"])
    def test_crash_leaves_old_file(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: str) -> None:
        """Whatever goes wrong while a file is replaced, the old one stays and no half of the new one."""
        target = tmp_path / "a.txt"
        target.write_bytes(b"old")

        def crash(self: Path, *_: object) -> None:
            if moment == "write_bytes":
                with self.open("wb") as file:
                    file.write(b"n")
            raise KeyboardInterrupt

        monkeypatch.setattr(Path, moment, crash)
        with pytest.raises(KeyboardInterrupt):
            write_whole(target, b"new")
        monkeypatch.undo()
        assert target.read_bytes() == b"old"
        assert [entry.name for entry in tmp_path.iterdir()] == ["a.txt"]

    def test_several_files_are_complete_before_the_first_is_placed(self, tmp_path: Path) -> None:
        """Files that belong together are all written before any of them is seen."""
        with files_module.parked(tmp_path, {"a": b"1", "deep/b": b"2"}) as place:
            assert not (tmp_path / "a").exists()
            assert len(list(tmp_path.rglob(".*.part"))) == 2
            place()
            assert (tmp_path / "deep" / "b").read_bytes() == b"2"
        assert not list(tmp_path.rglob("*.part"))

    def test_killed_writer_is_cleaned_up_after(self, tmp_path: Path) -> None:
        """What a killed process left under a temporary name is removed by the next run."""
        (tmp_path / "figures").mkdir()
        (tmp_path / "figures" / ".a.png.99.part").write_bytes(b"x")
        with open_run_folder(tmp_path):
            assert not list(tmp_path.rglob("*.part"))

    def test_permissions_follow_umask(self, tmp_path: Path) -> None:
        """Results are as readable as any file the user makes."""
        write_whole(tmp_path / "a", b"")
        (tmp_path / "b").touch()
        assert (tmp_path / "a").stat().st_mode == (tmp_path / "b").stat().st_mode

    def test_hash(self, tmp_path: Path) -> None:
        """The hash of a file is that of its content; no file has none."""
        (tmp_path / "a").write_bytes(b"abc")
        assert sha256(tmp_path / "a") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        assert sha256(tmp_path / "b") is None
        assert sha256(tmp_path) is None


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


class TestPlain:
    """Every value becomes what JSON can hold."""

    @settings(max_examples=50)
    @given(json_values)
    def test_round_trip(self, value: Any) -> None:
        """Plain values survive JSON, NaN and infinities as null."""

        def expected(item: Any) -> Any:
            if isinstance(item, float) and not math.isfinite(item):
                return None
            if isinstance(item, list):
                return [expected(each) for each in item]
            if isinstance(item, dict):
                return {key: expected(each) for key, each in item.items()}
            return item

        assert json.loads(json_bytes(value)) == expected(value)

    def test_numpy_and_other_types(self) -> None:
        """Arrays become lists, numpy's numbers numbers, dataclasses dictionaries, the unknown its text."""

        @dataclass
        class Pair:
            first: float
            second: object

        value = {
            Stage.ROUTE: np.array([[1.0, np.inf]]),
            "number": np.float64(2.0),
            "count": np.int64(3),
            "flag": np.bool_(True),
            "pair": Pair(np.nan, (1, {2})),
            "status": Status.OPTIMAL,
            "path": Path("a"),
        }
        assert plain(value) == {
            "route": [[1.0, None]],
            "number": 2.0,
            "count": 3,
            "flag": True,
            "pair": {"first": None, "second": [1, [2]]},
            "status": "optimal",
            "path": "a",
        }


class TestResults:
    """What is loaded is exactly what was saved."""

    def test_regions(self, tmp_path: Path, machine: Machine, make: Make) -> None:
        """The region table comes back to the last bit, from one array per column."""
        table = make["regions"](machine, 50)
        put(tmp_path, regions_files(table))
        assert same(load_regions(tmp_path), table)
        arrays = read_npz(tmp_path / "regions.npz")
        assert {array.shape for array in arrays.values()} == {(50,)}
        assert {"x_m", "rz_rad", "ry_rad", "mode", "gate", "q5_m", "kappa", "x_max_m"} <= set(arrays)

    def test_route(self, tmp_path: Path, machine: Machine, make: Make) -> None:
        """The route comes back with everything about its search."""
        route = make["route"](machine)
        put(tmp_path, route_files(route))
        loaded = load_route(tmp_path)
        assert same(loaded, route)
        assert loaded.search == route.search
        assert loaded.status is Status.OPTIMAL

    def test_route_csv(self, tmp_path: Path, machine: Machine, make: Make) -> None:
        """The route's table has the columns of the contract and the route's values."""
        route = make["route"](machine)
        columns = read_csv(route_files(route)["route.csv"].decode())
        assert list(columns) == (
            ["step", "region", "mode", "x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad", "kappa"]
            + [f"q{k}_m" for k in range(1, 6)]
            + ["gate"]
        )
        assert columns["mode"].tolist() == ["LLL", "LLL", "LLL", "LLR"]
        assert columns["region"].tolist() == route.region.tolist()
        np.testing.assert_allclose(columns["q5_m"], route.q_m[:, 4], atol=1e-12)

    def test_refinement(self, tmp_path: Path, machine: Machine, make: Make) -> None:
        """Both paths come back: the same positions, derivatives and poses, exactly."""
        refinement = make["refinement"](machine)
        s = np.linspace(0.0, 1.0, 37)
        put(tmp_path, path_files(refinement, sample_path(refinement.path, s)))
        loaded = load_refinement(tmp_path, machine)
        for name in ("status", "iterations", "rounds", "nodes", "surrogate_integral"):
            assert getattr(loaded, name) == getattr(refinement, name)
        for ours, theirs in ((loaded.path, refinement.path), (loaded.coarse, refinement.coarse)):
            assert np.array_equal(ours.q(s), theirs.q(s))
            assert np.array_equal(ours.q(s, 1), theirs.q(s, 1))
            assert np.array_equal(ours.pose(s), theirs.pose(s))

    def test_a_path_of_its_own(self, tmp_path: Path, machine: Machine, make: Make) -> None:
        """What is saved is loaded, and so is the refined path of a run."""
        refinement = make["refinement"](machine)
        save_path(tmp_path / "one.npz", refinement.path)
        s = np.linspace(0.0, 1.0, 21)
        (tmp_path / "run.npz").write_bytes(npz_bytes(pack_refinement(refinement)))
        for name in ("one.npz", "run.npz"):
            loaded = load_path(tmp_path / name, machine)
            for order in range(4):
                np.testing.assert_array_equal(loaded.q(s, order), refinement.path.q(s, order))
            np.testing.assert_array_equal(loaded.pose(s), refinement.path.pose(s))
        (tmp_path / "one.npz").write_bytes(b"nonsense")
        with pytest.raises(UsageError, match=r"one\.npz"):
            load_path(tmp_path / "one.npz", machine)

    def test_path_files_follow_the_contract(self, machine: Machine, make: Make) -> None:
        """The splines can be rebuilt from degree, knots and coefficients; the table has the contract's columns."""
        refinement = make["refinement"](machine)
        s = np.linspace(0.0, 1.0, 11)
        files = path_files(refinement, sample_path(refinement.path, s))
        arrays = np.load(io.BytesIO(files["path.npz"]))
        spline = BSpline(arrays["knots"], arrays["coefficients"], int(arrays["degree"]))
        assert arrays["coefficients"].shape[1] == 5
        columns = read_csv(files["path.csv"].decode())
        assert list(columns)[:8] == ["s", "x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad", "kappa"]
        q = np.column_stack([columns[f"q{k}_m"] for k in range(1, 6)])
        np.testing.assert_allclose(q, spline(s), atol=1e-12)

    def test_trajectory(self, tmp_path: Path, fast_config: Config, machine: Machine, make: Make) -> None:
        """The trajectory comes back exactly, and its sidecar tells of every column of its table."""
        trajectory = make["trajectory"](make["path"](machine, 5))
        samples = sample_trajectory(trajectory, 0.01)
        usage = measure_usage(trajectory)
        put(tmp_path, trajectory_files(trajectory, samples, sidecar(fast_config, machine, samples, usage)))
        loaded = load_trajectory(tmp_path, trajectory.path)
        t = np.linspace(0.0, 2.0, 33)
        for derivative in range(3):
            assert np.array_equal(loaded.q(t, derivative), trajectory.q(t, derivative))
        columns = read_csv((tmp_path / "trajectory.csv").read_text())
        described = json.loads((tmp_path / "trajectory.json").read_text())["columns"]
        assert [column["name"] for column in described] == list(columns)

    def test_same_arrays_same_bytes(self) -> None:
        """Hashes of results depend on their values alone, not on when they were written."""
        content = npz_bytes({"a": np.arange(5.0), "b": "text"})
        assert npz_bytes({"a": np.arange(5.0), "b": "text"}) == content
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}

    def test_figures_are_pictures(self) -> None:
        """Every figure becomes a PNG and a PDF of its own name, the same bytes every time."""
        files = figure_files({"kappa": Figure((1, 1))})
        assert list(files) == ["figures/kappa.png", "figures/kappa.pdf"]
        assert files["figures/kappa.png"].startswith(b"\x89PNG")
        assert files["figures/kappa.pdf"].startswith(b"%PDF")
        assert figure_files({"kappa": Figure((1, 1))}) == files

    @pytest.mark.parametrize("damage", ["other", "short", "pickle"])
    def test_unreadable_file_is_named(self, tmp_path: Path, machine: Machine, make: Make, damage: str) -> None:
        """A file of another format is refused with its name and what to do, not with a traceback."""
        if damage == "other":
            put(tmp_path, {"route.npz": npz_bytes({"region": np.arange(3)})})
        elif damage == "short":
            put(tmp_path, {"route.npz": route_files(make["route"](machine))["route.npz"][:500]})
        else:
            np.savez(tmp_path / "route.npz", region=np.array([object()], dtype=object))
        with pytest.raises(UsageError, match=r"route\.npz cannot be read"):
            load_route(tmp_path)

    def test_failures_are_kept_apart(self) -> None:
        """A diagnosis is kept under names no result has: numbers and words as JSON, arrays beside it."""
        diagnosis = {"pose": np.eye(2), "s": 0.5, "worst": np.inf, "odd": np.array([None])}
        files = failure_files(Stage.REFINE, {"reason": "why"}, diagnosis)
        assert list(files) == ["failed/refine.json", "failed/refine.npz"]
        told = json.loads(files["failed/refine.json"])
        assert told["reason"] == "why"
        assert told["diagnosis"] == {"s": 0.5, "worst": None, "odd": [None]}
        assert told["arrays"] == ["pose"]
        assert list(failure_files(Stage.REFINE, {}, {"s": 1})) == ["failed/refine.json"]


def record(**values: Any) -> Record:
    """Make a record."""
    defaults = {"fingerprint": "f", "status": "done", "seconds": 1.5, "files": {}, "summary": {"kappa": None}}
    return Record.model_validate({**defaults, **values})


class TestFolder:
    """A run folder changes all at once and loses nothing."""

    def change(self, path: Path, files: dict[str, bytes], superseded: list[str], state: State | None = None) -> None:
        """Change a run folder in one step."""
        with open_run_folder(path) as folder:
            folder.change(state or State(), files, superseded, "name: a\n", {"name": "a"})

    def test_state_round_trip(self, tmp_path: Path) -> None:
        """What a folder remembers is what the next run reads."""
        state = State(config_sha256="c", stages={Stage.ROUTE: record(files={"route.npz": "h"})})
        self.change(tmp_path, {"route.npz": b"r"}, [], state)
        assert read_state(tmp_path) == state
        assert state.stages[Stage.ROUTE].result_sha256(Stage.ROUTE) == "h"
        assert state.stages[Stage.ROUTE].result_sha256(Stage.REFINE) == ""

    @pytest.mark.parametrize("content", [b"", b"{", b'{"stages": {"other": {}}}', b'{"stages": {"route": 1}}'])
    def test_unreadable_state_is_no_results(self, tmp_path: Path, content: bytes) -> None:
        """A damaged state means that nothing is known, not a crash."""
        (tmp_path / "state.json").write_bytes(content)
        assert read_state(tmp_path) == State()

    def test_no_folder_has_no_state(self, tmp_path: Path) -> None:
        """Where no run was there is no state."""
        assert read_state(tmp_path / "none") is None

    def test_superseded_files_are_kept_with_their_context(self, tmp_path: Path) -> None:
        """Replaced results move to a numbered folder with the configuration and state they belong to."""
        self.change(tmp_path, {"route.csv": b"1", "figures/a.png": b"p"}, [])
        before = (tmp_path / "state.json").read_bytes()
        self.change(tmp_path, {"route.csv": b"2"}, ["route.csv", "figures/a.png"], State(config_sha256="new"))
        old = tmp_path / "superseded" / "0001"
        assert (old / "route.csv").read_bytes() == b"1"
        assert (old / "figures" / "a.png").read_bytes() == b"p"
        assert (old / "state.json").read_bytes() == before
        assert (tmp_path / "route.csv").read_bytes() == b"2"
        assert not (tmp_path / "figures").exists()
        self.change(tmp_path, {"route.csv": b"3"}, ["route.csv"])
        assert (tmp_path / "superseded" / "0002" / "route.csv").read_bytes() == b"2"

    def test_one_run_supersedes_into_one_folder(self, tmp_path: Path) -> None:
        """All that a run replaces is in one place, with the configuration from before the run."""
        self.change(tmp_path, {"route.csv": b"1", "path.csv": b"1"}, [])
        with open_run_folder(tmp_path) as folder:
            folder.change(State(), {}, ["route.csv"], "name: b\n", {})
            folder.change(State(), {}, ["path.csv"], "name: b\n", {})
        old = tmp_path / "superseded" / "0001"
        assert {"route.csv", "path.csv"} <= {path.name for path in old.iterdir()}
        assert (old / "config.yaml").read_text() == "name: a\n"

    def test_unchanged_files_do_not_move(self, tmp_path: Path) -> None:
        """A result that came out the same as before supersedes nothing."""
        self.change(tmp_path, {"route.csv": b"1"}, [])
        self.change(tmp_path, {"route.csv": b"1"}, ["route.csv"])
        assert not (tmp_path / "superseded").exists()
        assert (tmp_path / "route.csv").read_bytes() == b"1"

    def test_failed_writing_changes_nothing(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        """When the disk is full half way, old results, summary and state are all still there."""
        self.change(tmp_path, {"route.csv": b"1"}, [], State(config_sha256="old"))
        before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
        write = Path.write_bytes

        def full(self: Path, content: bytes) -> int:
            if "summary" in self.name:
                raise OSError(28, "No space left on device", str(self))
            return write(self, content)

        monkeypatch.setattr(Path, "write_bytes", full)
        with pytest.raises(OSError, match="No space left"):
            self.change(tmp_path, {"route.csv": b"2"}, ["route.csv"], State(config_sha256="new"))
        monkeypatch.undo()
        after = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
        assert {**after, ".lock": b""} == {**before, ".lock": b""}

    def test_one_run_at_a_time(self, tmp_path: Path) -> None:
        """A second run into the same folder is refused, and told who is there."""
        with (
            open_run_folder(tmp_path),
            pytest.raises(UsageError, match=f"process {os.getpid()}.*at work"),
            open_run_folder(tmp_path),
        ):
            pass
        with open_run_folder(tmp_path):
            pass

    def test_lock_of_a_killed_run_does_not_stay(self, tmp_path: Path) -> None:
        """A run that was killed keeps nobody out."""
        script = f"""
            import os, pathlib, signal
            from pipeline.artifacts import open_run_folder
            with open_run_folder(pathlib.Path({str(tmp_path)!r})):
                os.kill(os.getpid(), signal.SIGKILL)
        """
        subprocess.run([sys.executable, "-c", textwrap.dedent(script)], check=False)
        assert (tmp_path / ".lock").read_text() != ""
        with open_run_folder(tmp_path):
            pass

    @pytest.mark.parametrize("name", ["config.yaml", "trajectory.csv", "figures/mine.png"])
    def test_foreign_files_are_not_overwritten(self, tmp_path: Path, name: str) -> None:
        """A folder with files of the same names that is no run folder is left alone."""
        put(tmp_path, {name: b"mine"})
        with pytest.raises(UsageError, match=f"already holds {name}"), open_run_folder(tmp_path):
            pass
        assert [path for path in tmp_path.rglob("*") if path.is_file()] == [tmp_path / name]

    def test_a_file_is_no_folder(self, tmp_path: Path) -> None:
        """A file in the place of the folder is told as such."""
        (tmp_path / "out").touch()
        with pytest.raises(UsageError, match="is a file"), open_run_folder(tmp_path / "out"):
            pass

    def test_reading_needs_a_run(self, tmp_path: Path, fast_config: Config) -> None:
        """Looking at results needs a run folder whose configuration is that of its results."""
        with pytest.raises(UsageError, match="does not exist"):
            read_run_folder(tmp_path / "none")
        with pytest.raises(UsageError, match="is no run folder"):
            read_run_folder(tmp_path)
        with open_run_folder(tmp_path) as folder:
            folder.change(State(config_sha256=config_sha256(fast_config)), {}, [], dump_config(fast_config), {})
        assert read_run_folder(tmp_path)[0] == fast_config
        text = (tmp_path / "config.yaml").read_text()
        (tmp_path / "config.yaml").write_text(text.replace("step_budget: 25", "step_budget: 24"))
        with pytest.raises(UsageError, match="was changed after the run"):
            read_run_folder(tmp_path)

    def test_damage_is_seen(self, tmp_path: Path) -> None:
        """Files that were edited or removed no longer fit their record."""
        put(tmp_path, {"a": b"abc", "b": b"abc"})
        known = record(files={name: sha256(tmp_path / "a") for name in ("a", "b", "c")})
        (tmp_path / "b").write_bytes(b"abd")
        assert known.damage(tmp_path) == ["b", "c"]


class TestLayout:
    """The stages and the names of their files."""

    def test_order(self) -> None:
        """Every stage knows what is before and after it."""
        assert Stage.REGIONS.earlier == ()
        assert Stage.ROUTE.later == (Stage.REFINE, Stage.CERTIFY, Stage.RETIME, Stage.FIGURES)
        assert all((*stage.earlier, stage, *stage.later) == STAGES for stage in STAGES)

    def test_files_of_a_stage(self, tmp_path: Path) -> None:
        """Results, pictures and diagnoses are found with the stage that made them."""
        put(tmp_path, {"route.csv": b"", "figures/a.png": b"", "failed/route.json": b"", "figures/a.txt": b""})
        put(tmp_path, {"figures/a.pdf": b""})
        assert existing_files(tmp_path, Stage.ROUTE) == ["route.csv", "failed/route.json"]
        assert existing_files(tmp_path, Stage.FIGURES) == ["figures/a.pdf", "figures/a.png"]
        assert existing_files(tmp_path, Stage.RETIME) == []

    def test_sights_exist(self, tmp_path: Path) -> None:
        """Only files that are there are recommended."""
        put(tmp_path, {"route.csv": b"", "summary.json": b""})
        assert [path.name for path, _ in sights(tmp_path, STAGES)] == ["route.csv", "summary.json"]
