"""Running stages: what runs again and when, what becomes of old results, what the summary says."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.file import config_sha256, load_config
from pipeline.errors import (
    ConfigError,
    ConfigIssue,
    ForwardKinematicsError,
    NoSolutionError,
    UnfitConfigError,
    UsageError,
)
from pipeline.machine import Machine
from pipeline.progress import Progress
from pipeline.run import Quiet, RunReport, Stage, run_pipeline
from pipeline.run.fingerprint import UPSTREAM, config_part, fingerprint
from pipeline.run.reading import open_results, with_retime

ALL = ["regions", "route", "refine", "certify", "retime", "figures"]
RESULT_FILES = {
    "regions.npz",
    "route.npz",
    "route.csv",
    "path.npz",
    "path.csv",
    "certificate.json",
    "trajectory.npz",
    "trajectory.csv",
    "trajectory.json",
    "trajectory_back.csv",
    "trajectory_back.json",
    "report.html",
    "figures/route.png",
    "figures/route.pdf",
    "figures/kappa.png",
    "figures/kappa.pdf",
}
BOOKS = {"config.yaml", "summary.json", "state.json", ".lock"}

Change = Callable[..., Config]


def files(folder: Path) -> set[str]:
    """Names of all files in a folder."""
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def content(folder: Path) -> dict[str, bytes]:
    """Content of all files but the lock, which holds a process number."""
    return {name: (folder / name).read_bytes() for name in files(folder) - {".lock"}}


def summary(folder: Path) -> dict[str, Any]:
    """Read the summary, insisting that it is strict JSON."""

    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is no JSON")

    data: dict[str, Any] = json.loads((folder / "summary.json").read_text(), parse_constant=refuse)
    return data


class TestWhole:
    """A run from nothing."""

    def test_all_files(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """A whole run writes every file of the contract and nothing else."""
        report = run_pipeline(fast_config, tmp_path / "a" / "b")
        assert stages.calls == ALL
        assert files(tmp_path / "a" / "b") == RESULT_FILES | BOOKS
        assert [outcome.outcome for outcome in report.outcomes] == ["done"] * 6
        assert load_config(tmp_path / "a" / "b" / "config.yaml") == fast_config

    def test_summary(self, tmp_path: Path, fast_config: Config, stages: Any, machine: Machine, make: Any) -> None:
        """The summary has every key of the contract, with the figures of the results."""
        report = run_pipeline(fast_config, tmp_path)
        told = summary(tmp_path)
        assert told == json.loads(json.dumps(report.summary))
        assert told["name"] == "quick"
        assert told["config_sha256"] == config_sha256(fast_config)
        assert {"gantry-tau", "python", "numpy", "scipy", "highspy", "casadi", "toppra"} <= set(told["versions"])
        assert told["regions"]["count"] == 5
        assert told["regions"]["gates"] == make["regions"](machine).gate_count
        assert told["regions"]["nominal_variables"] == (13 + 5) * 25
        route = told["route"]
        assert {"status", "solver", "objective", "bound", "gap", "steps", "kappa_max", "mode_changes"} <= set(route)
        assert (route["status"], route["steps"], route["mode_changes"]) == ("optimal", 4, 1)
        assert route["kappa_max"] == 1.0 / 0.03
        path = told["path"]
        assert set(path) >= {
            "status",
            "iterations",
            "kappa_max",
            "kappa_integral",
            "coarse_kappa_max",
            "coarse_kappa_integral",
            "length",
            "coarse_length",
            "closure_residual_m",
            "min_link_distance_m",
            "max_tilt_deg",
        }
        assert path["status"] == "converged"
        assert path["kappa_integral"] == pytest.approx(path["coarse_kappa_integral"], rel=1e-3)
        assert path["det_sign_constant"] is True
        certificate = told["certificate"]
        assert certificate["verdict"] == "certified"
        assert (certificate["boxes"], certificate["kappa_bound"], certificate["tolerance_m"]) == (1, 31.0, 1e-4)
        assert certificate["min_distance_bound_m"] == 0.1
        trajectory = told["trajectory"]
        assert trajectory["duration_s"] == 2.0
        assert trajectory["samples"] == 201
        assert trajectory["usage"]["tcp_speed"] == trajectory["usage"]["tcp_acceleration"] == "skipped"
        assert {len(trajectory["usage"][name]) for name in ("velocity", "acceleration", "jerk", "force")} == {5}
        assert len(trajectory["usage"]["link_force"]) == 6
        assert trajectory["back"]["duration_s"] == 2.0
        assert all(told[part]["seconds"] >= 0.0 for part in ("regions", "route", "path", "trajectory"))

    def test_path_table_gives_the_summary(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """Anyone can recompute the summary's figures from path.csv."""
        from pipeline.export import read_csv

        run_pipeline(fast_config, tmp_path)
        columns = read_csv((tmp_path / "path.csv").read_text())
        assert len(columns["s"]) == fast_config.refine.check_points
        assert columns["kappa"].max() == pytest.approx(summary(tmp_path)["path"]["kappa_max"], abs=1e-9)

    def test_figures_are_those_of_the_result(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """Results loaded from the folder are those that were made."""
        run_pipeline(fast_config, tmp_path)
        results = open_results(tmp_path, *list(Stage)[:-1])
        assert len(results.regions) == 5
        assert results.route.objective == 100.0
        assert results.refinement.iterations == 17
        assert results.trajectory.duration_s == 2.0

    def test_verbose_reaches_the_solvers(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """Solvers talk only when asked to."""
        run_pipeline(fast_config, tmp_path, verbose=True)
        run_pipeline(fast_config, tmp_path, force=True)
        assert stages.verbose == [True, True, False, False]

    def test_reporter(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """The reporter hears of every stage, and what the stage has to say."""
        heard: list[tuple[Any, ...]] = []

        class Listener:
            def begin(self, stage: Stage) -> Progress:
                heard.append(("begin", str(stage)))
                return lambda message, fraction=None: heard.append((message, fraction))

            def end(self, stage: Stage, outcome: str, seconds: float) -> None:
                heard.append(("end", str(stage), outcome))

        run_pipeline(fast_config, tmp_path, last=Stage.REGIONS, reporter=Listener())
        run_pipeline(fast_config, tmp_path, last=Stage.REGIONS, reporter=Listener())
        assert heard == [
            ("begin", "regions"),
            ("working", None),
            ("still working", 0.5),
            ("end", "regions", "done"),
            ("end", "regions", "unchanged"),
        ]
        Quiet().end(Stage.ROUTE, "done", 0.0)


class TestCaching:
    """A stage whose inputs have not changed is not run again."""

    def test_nothing_changed(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """A second run does nothing, and leaves the results byte for byte."""
        run_pipeline(fast_config, tmp_path)
        before = content(tmp_path)
        stages.taken()
        report = run_pipeline(fast_config, tmp_path)
        assert stages.calls == []
        assert content(tmp_path) == before
        assert [outcome.outcome for outcome in report.outcomes] == ["unchanged"] * 6

    @pytest.mark.parametrize(
        ("key", "value", "again"),
        [
            ("name", "other", ["retime", "figures"]),
            ("machine__links__l1__length_m", 1.1, ["regions", "route", "refine", "certify"]),
            ("machine__clearance__link_link_m", 0.02, ["regions", "route", "refine", "certify"]),
            ("machine__limits__carts__velocity_mps", 0.4, []),
            ("task__goal__z_m", 0.91, ["regions", "route", "refine", "certify"]),
            ("task__tilt_max_deg", 25.0, ["regions", "route", "refine", "certify"]),
            ("task__locked_axes", ["rz"], ["regions", "route", "refine", "certify"]),
            ("task__budget__travel_m", 9.0, ["route", "refine", "certify"]),
            ("route__grid__y_m__step", 0.2, ["regions", "route", "refine", "certify"]),
            ("route__kappa_max", 90.0, ["regions", "route", "refine", "certify"]),
            ("route__x_step_m", 0.2, ["route", "refine", "certify"]),
            ("route__step_budget", 24, ["route", "refine", "certify"]),
            ("route__follow__max_samples", 32, ["route", "refine", "certify"]),
            ("refine__nodes", 90, ["refine", "certify"]),
            ("refine__check_points", 1_001, ["refine", "certify"]),
            ("certify__kappa_excess", 0.1, ["certify"]),
            ("certify__what", "tolerances", ["certify"]),
            ("certify__monte_carlo_samples", 9, []),
            ("certify__tolerance_resolution", 0.5, []),
            ("retime__period_s", 0.02, []),
            ("retime__jerk", False, []),
            ("machine__dynamics__load_kg", 1.0, []),
            ("machine__limits__tcp__speed_mps", 0.3, []),
        ],
    )
    def test_what_runs_again(
        self,
        tmp_path: Path,
        fast_config: Config,
        stages: Any,
        change: Change,
        key: str,
        value: Any,
        again: list[str],
    ) -> None:
        """Each key runs exactly the stages again that read it, and those whose files quote the configuration."""
        run_pipeline(fast_config, tmp_path)
        stages.taken()
        run_pipeline(change(fast_config, **{key: value}), tmp_path)
        assert stages.calls == [*again, *(stage for stage in ("retime", "figures") if stage not in again)]

    def test_files_quote_the_current_configuration(
        self, tmp_path: Path, fast_config: Config, stages: Any, change: Change
    ) -> None:
        """After any change the hash in the trajectory's sidecar is that of the summary."""
        run_pipeline(fast_config, tmp_path)
        run_pipeline(change(fast_config, route__step_budget=24), tmp_path)
        sidecar = json.loads((tmp_path / "trajectory.json").read_text())
        assert sidecar["config_sha256"] == summary(tmp_path)["config_sha256"]

    def test_other_result_runs_later_stages(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """When a stage comes out differently, everything that builds on it runs again."""
        run_pipeline(fast_config, tmp_path)
        stages.taken()
        stages.objective = 101.0
        run_pipeline(fast_config, tmp_path, first=Stage.ROUTE, last=Stage.ROUTE)
        assert stages.taken() == ["route"]
        assert files(tmp_path) & RESULT_FILES == {"regions.npz", "route.npz", "route.csv"}
        run_pipeline(fast_config, tmp_path)
        assert stages.calls == ["refine", "certify", "retime", "figures"]

    def test_same_result_stops_the_chain(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """When a stage run again comes out the same, what builds on it stays good."""
        run_pipeline(fast_config, tmp_path)
        before = content(tmp_path)
        stages.taken()
        run_pipeline(fast_config, tmp_path, first=Stage.ROUTE, last=Stage.ROUTE)
        assert stages.taken() == ["route"]
        run_pipeline(fast_config, tmp_path)
        assert stages.calls == []
        assert {name: content(tmp_path)[name] for name in RESULT_FILES} == {name: before[name] for name in RESULT_FILES}
        assert not (tmp_path / "superseded").exists()

    def test_version_and_code(
        self, tmp_path: Path, fast_config: Config, stages: Any, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Another version of the package, or other code of a stage, makes results outdated."""
        run_pipeline(fast_config, tmp_path)
        stages.taken()
        monkeypatch.setattr("pipeline.run.fingerprint.package_version", lambda: "99.0")
        run_pipeline(fast_config, tmp_path)
        assert stages.taken() == ALL
        monkeypatch.setattr("pipeline.run.fingerprint._code_sha256", lambda package: package == "retime" or "")
        run_pipeline(fast_config, tmp_path)
        before = stages.taken()
        monkeypatch.setattr("pipeline.run.fingerprint._code_sha256", lambda package: "")
        run_pipeline(fast_config, tmp_path)
        assert before == ALL
        assert stages.calls == ["retime", "figures"]

    @pytest.mark.parametrize(
        ("name", "again"),
        [
            ("regions.npz", ["regions"]),
            ("route.csv", ["route"]),
            ("route.npz", ["route"]),
            ("path.csv", ["refine"]),
            ("trajectory.json", ["retime"]),
            ("figures/kappa.png", ["figures"]),
        ],
    )
    @pytest.mark.parametrize("damage", ["edited", "removed"])
    def test_damaged_files_are_made_anew(
        self, tmp_path: Path, fast_config: Config, stages: Any, name: str, again: list[str], damage: str
    ) -> None:
        """A file that was edited or removed makes its stage run again; the edited one is kept aside."""
        run_pipeline(fast_config, tmp_path)
        good = (tmp_path / name).read_bytes()
        stages.taken()
        if damage == "edited":
            (tmp_path / name).write_bytes(b"mine")
        else:
            (tmp_path / name).unlink()
        run_pipeline(fast_config, tmp_path)
        assert stages.calls == again
        assert (tmp_path / name).read_bytes() == good
        if damage == "edited":
            assert (tmp_path / "superseded" / "0001" / name).read_bytes() == b"mine"

    @pytest.mark.parametrize("state", [b"", b"nonsense", b"{}"])
    def test_damaged_state_runs_everything(
        self, tmp_path: Path, fast_config: Config, stages: Any, state: bytes
    ) -> None:
        """Without a readable state nothing counts as done, and old files move aside when they are replaced."""
        run_pipeline(fast_config, tmp_path)
        (tmp_path / "state.json").write_bytes(state)
        stages.taken()
        stages.objective = 101.0
        run_pipeline(fast_config, tmp_path, last=Stage.ROUTE)
        assert stages.calls == ["regions", "route"]
        assert files(tmp_path) & RESULT_FILES == {"regions.npz", "route.npz", "route.csv"}
        assert "superseded/0001/trajectory.csv" in files(tmp_path)

    def test_force(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """Forced, everything in range runs again."""
        run_pipeline(fast_config, tmp_path)
        stages.taken()
        run_pipeline(fast_config, tmp_path, force=True)
        assert stages.taken() == ALL
        run_pipeline(fast_config, tmp_path, force=True, last=Stage.ROUTE)
        assert stages.taken() == ["regions", "route"]
        run_pipeline(fast_config, tmp_path, force=True, first=Stage.RETIME)
        assert stages.taken() == ["retime", "figures"]

    def test_config_parts_grow(self, fast_config: Config) -> None:
        """Every stage depends on what the stage it builds on depends on, so that no change gets lost."""

        def leaves(value: Any, path: str = "") -> set[str]:
            if isinstance(value, dict):
                return {leaf for key, item in value.items() for leaf in leaves(item, f"{path}.{key}")}
            return {path}

        for stage, upstream in UPSTREAM.items():
            for earlier in upstream:
                assert leaves(config_part(fast_config, earlier)) <= leaves(config_part(fast_config, stage))

    def test_fingerprint_depends_on_results(self, fast_config: Config) -> None:
        """Another result of an earlier stage gives another fingerprint."""
        one, other = ({Stage.REGIONS: name} for name in "ab")
        assert fingerprint(fast_config, Stage.ROUTE, one) == fingerprint(fast_config, Stage.ROUTE, one)
        assert fingerprint(fast_config, Stage.ROUTE, one) != fingerprint(fast_config, Stage.ROUTE, other)


class Recorder:
    """Stands for an object and notes which of its leaves are read."""

    def __init__(self, target: Any, read: set[str], path: str = "") -> None:
        self._target, self._read, self._path = target, read, path

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._target, name)
        path = f"{self._path}.{name}".lstrip(".")
        if hasattr(type(value), "model_fields"):
            return Recorder(value, self._read, path)
        self._read.add(path)
        return value


def declared(config: Config, stage: Stage, path: str) -> bool:
    """Tell whether a key is part of what a stage may read."""
    part: Any = config_part(config, stage)
    for key in path.split("."):
        if not isinstance(part, dict) or key not in part:
            return not isinstance(part, dict)
        part = part[key]
    return True


@pytest.mark.slow
def test_stages_read_only_what_they_declare(quick_config: Config, machine: Machine, change: Change) -> None:
    """The real stages read no key that their fingerprint leaves out; one that does would keep stale results."""
    from dataclasses import replace

    from pipeline.refine import refine_path
    from pipeline.route import build_regions, plan_route

    config = change(quick_config, refine__nodes=40, refine__coefficients=16)
    blind = replace(machine, velocity_mps=np.full(5, np.nan), acceleration_mps2=np.full(5, np.nan))
    results: list[Any] = []
    for stage, make in (
        (Stage.REGIONS, lambda config: build_regions(config, blind)),
        (Stage.ROUTE, lambda config: plan_route(config, blind, results[0])),
        (Stage.REFINE, lambda config: refine_path(config, blind, results[1])),
    ):
        read: set[str] = set()
        results.append(make(Recorder(config, read)))
        assert read
        # How much memory may be used decides how, not what.
        read.discard("route.memory_gb")
        assert [path for path in sorted(read) if not declared(config, stage, path)] == []


class TestRange:
    """Running a part of the stages."""

    def test_to(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """Stages after the last are not run and the summary says that they were skipped."""
        report = run_pipeline(fast_config, tmp_path, last=Stage.ROUTE)
        assert stages.calls == ["regions", "route"]
        assert files(tmp_path) == {"regions.npz", "route.npz", "route.csv"} | BOOKS
        assert summary(tmp_path)["path"] == summary(tmp_path)["trajectory"] == {"status": "skipped"}
        assert [outcome.stage for outcome in report.outcomes] == ["regions", "route"]

    def test_to_keeps_later_results_that_still_fit(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """Stopping early leaves later results alone while they are up to date."""
        run_pipeline(fast_config, tmp_path)
        run_pipeline(fast_config, tmp_path, last=Stage.ROUTE)
        assert files(tmp_path) == RESULT_FILES | BOOKS
        assert summary(tmp_path)["trajectory"]["duration_s"] == 2.0

    def test_to_moves_later_results_that_do_not(
        self, tmp_path: Path, fast_config: Config, stages: Any, change: Change
    ) -> None:
        """Nothing of another configuration stays beside the new one, even if no stage had to run."""
        run_pipeline(fast_config, tmp_path)
        stages.taken()
        run_pipeline(change(fast_config, retime__period_s=0.02), tmp_path, last=Stage.REFINE)
        assert stages.calls == []
        assert not {"trajectory.csv", "figures/route.png"} & files(tmp_path)
        assert "superseded/0001/trajectory.csv" in files(tmp_path)
        old = load_config(tmp_path / "superseded" / "0001" / "config.yaml")
        assert old.retime.period_s == 0.01
        assert load_config(tmp_path / "config.yaml").retime.period_s == 0.02
        assert summary(tmp_path)["trajectory"] == {"status": "skipped"}

    def test_from(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """From a stage on, it and the later ones run, on earlier results loaded from the folder."""
        run_pipeline(fast_config, tmp_path)
        stages.taken()
        run_pipeline(fast_config, tmp_path, first=Stage.REFINE)
        assert stages.calls == ["refine", "certify", "retime", "figures"]

    def test_from_without_earlier_results(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """Without a folder to build on, the user is told, and none is made."""
        with pytest.raises(UsageError, match="there are none in"):
            run_pipeline(fast_config, tmp_path / "new", first=Stage.REFINE)
        assert not (tmp_path / "new").exists()
        run_pipeline(fast_config, tmp_path / "new", first=Stage.REGIONS, last=Stage.REGIONS)
        with pytest.raises(UsageError, match="result of route, which has not been run here"):
            run_pipeline(fast_config, tmp_path / "new", first=Stage.REFINE)

    def test_from_with_outdated_results(self, tmp_path: Path, fast_config: Config, stages: Any, change: Change) -> None:
        """Outdated or damaged earlier results are named, and nothing is touched."""
        run_pipeline(fast_config, tmp_path)
        other = change(fast_config, route__step_budget=24)
        before = content(tmp_path)
        stages.taken()
        with pytest.raises(UsageError, match=r"result of route, which was run with another.*\n.*--to route"):
            run_pipeline(other, tmp_path, first=Stage.REFINE)
        assert content(tmp_path) == before
        (tmp_path / "path.csv").write_bytes(b"mine")
        with pytest.raises(UsageError, match=r"removed or changed since \(path\.csv\)"):
            run_pipeline(fast_config, tmp_path, first=Stage.RETIME)
        assert stages.calls == []

    def test_from_after_failure(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """A failed stage is nothing to build on."""
        stages.failures["route"] = NoSolutionError("route", "none", "more")
        with pytest.raises(NoSolutionError):
            run_pipeline(fast_config, tmp_path)
        with pytest.raises(UsageError, match="result of route, which failed"):
            run_pipeline(fast_config, tmp_path, first=Stage.REFINE)

    def test_empty_range(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """A range that ends before it begins is refused."""
        with pytest.raises(UsageError, match="--from refine comes after --to route"):
            run_pipeline(fast_config, tmp_path, first=Stage.REFINE, last=Stage.ROUTE)
        assert files(tmp_path) == set()


class TestFailure:
    """Failed stages leave a diagnosis, and no result."""

    def test_no_solution(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """Reason, advice and diagnosis are kept, the summary tells them, later parts are skipped."""
        diagnosis = {"status": "infeasible", "cut": np.arange(3), "bound": np.inf}
        stages.failures["refine"] = NoSolutionError("refine", "no way", "widen it", diagnosis)
        with pytest.raises(NoSolutionError) as caught:
            run_pipeline(fast_config, tmp_path)
        assert str(tmp_path / "failed" / "refine.json") in caught.value.__notes__[0]
        assert files(tmp_path) == BOOKS | {
            "regions.npz",
            "route.npz",
            "route.csv",
            "failed/refine.json",
            "failed/refine.npz",
            "failed/refine.html",
        }
        told = json.loads((tmp_path / "failed" / "refine.json").read_text())
        assert (told["reason"], told["advice"]) == ("no way", "widen it")
        assert told["diagnosis"] == {"status": "infeasible", "bound": None}
        assert np.load(tmp_path / "failed" / "refine.npz")["cut"].tolist() == [0, 1, 2]
        part = summary(tmp_path)["path"]
        assert (part["status"], part["reason"], part["advice"]) == ("infeasible", "no way", "widen it")
        assert summary(tmp_path)["route"]["status"] == "optimal"
        assert summary(tmp_path)["trajectory"] == {"status": "skipped"}

    def test_other_failures_of_a_stage(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """A failure without advice of its own is kept with its message."""
        stages.failures["retime"] = ForwardKinematicsError(0.1, 3, [0.0] * 6)
        with pytest.raises(ForwardKinematicsError):
            run_pipeline(fast_config, tmp_path)
        part = summary(tmp_path)["trajectory"]
        assert part["status"] == "failed"
        assert "did not converge for entry 3" in part["reason"]

    def test_a_failed_way_back_leaves_the_way_there(
        self, tmp_path: Path, fast_config: Config, stages: Any, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """The motion is a result, what fails is told as failed every time, and no file of an older way back stays."""

        def fail(*_: object) -> None:
            raise NoSolutionError("retime", "on the way back, c2 is too weak", "a stronger one")

        run_pipeline(fast_config, tmp_path).require_complete()
        monkeypatch.setattr("pipeline.retime.way_back", fail)
        report = run_pipeline(fast_config, tmp_path, first=Stage.RETIME)
        for again in (report, run_pipeline(fast_config, tmp_path)):
            with pytest.raises(NoSolutionError, match=r"on the way back, c2 is too weak\n.*a stronger one") as caught:
                again.require_complete()
            assert caught.value.exit_code == 1
        told = summary(tmp_path)["trajectory"]
        assert (told["status"], told["back"]["status"]) == ("done", "failed")
        assert (told["back"]["reason"], told["back"]["advice"]) == ("on the way back, c2 is too weak", "a stronger one")
        kept = files(tmp_path)
        assert {"trajectory.csv", "trajectory.npz", "figures/route.png"} <= kept
        assert not {"trajectory_back.csv", "trajectory_back.json"} & kept

    def test_a_trajectory_too_long_to_write_leaves_nothing_stale(
        self, tmp_path: Path, fast_config: Config, stages: Any, change: Change
    ) -> None:
        """What was asked for cannot be had: the rows of another configuration do not stay in its place."""
        run_pipeline(fast_config, tmp_path)
        stages.failures["retime"] = UnfitConfigError("retime", "retime.period_s makes too many rows", "Raise it.")
        with pytest.raises(UnfitConfigError, match="too many rows"):
            run_pipeline(change(fast_config, retime__speed=0.000_02), tmp_path)
        kept = files(tmp_path)
        assert "trajectory.csv" not in kept
        assert "superseded/0001/trajectory.csv" in kept
        assert summary(tmp_path)["trajectory"]["status"] == "failed"
        assert summary(tmp_path)["path"]["status"] == "converged"

    def test_failure_supersedes_old_results(
        self, tmp_path: Path, fast_config: Config, stages: Any, change: Change
    ) -> None:
        """After a failure nothing looks like the result of it or of a later stage, and nothing is lost."""
        run_pipeline(fast_config, tmp_path)
        stages.failures["route"] = NoSolutionError("route", "none", "more")
        with pytest.raises(NoSolutionError):
            run_pipeline(change(fast_config, route__step_budget=5), tmp_path)
        kept = files(tmp_path)
        assert kept & RESULT_FILES == {"regions.npz"}
        assert {f"superseded/0001/{name}" for name in RESULT_FILES - {"regions.npz"}} <= kept

    def test_failure_is_tried_again_and_forgotten(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """A failed stage runs again every time; once it works its old diagnosis moves aside."""
        stages.failures["route"] = NoSolutionError("route", "none", "more")
        for _ in range(2):
            with pytest.raises(NoSolutionError):
                run_pipeline(fast_config, tmp_path)
        assert stages.taken() == ["regions", "route", "route"]
        stages.failures.clear()
        run_pipeline(fast_config, tmp_path)
        assert stages.calls == ["route", "refine", "certify", "retime", "figures"]
        current = {name for name in files(tmp_path) if not name.startswith("superseded/")}
        assert current == RESULT_FILES | BOOKS
        assert any(name.endswith("failed/route.json") for name in files(tmp_path))

    def test_failure_of_another_configuration_is_not_told(
        self, tmp_path: Path, fast_config: Config, stages: Any, change: Change
    ) -> None:
        """A failure belongs to its configuration like a result does."""
        stages.failures["refine"] = NoSolutionError("refine", "none", "more")
        with pytest.raises(NoSolutionError):
            run_pipeline(fast_config, tmp_path)
        run_pipeline(change(fast_config, refine__nodes=90), tmp_path, last=Stage.ROUTE)
        assert summary(tmp_path)["path"] == {"status": "skipped"}
        assert not (tmp_path / "failed").exists()

    @pytest.mark.parametrize(
        "error", [ConfigError([ConfigIssue("route.grid", "is empty")]), UsageError("no"), KeyboardInterrupt()]
    )
    @pytest.mark.parametrize(
        ("stage", "key", "value"), [("route", "route__step_budget", 24), ("retime", "retime__speed", 2e-5)]
    )
    def test_refusals_and_interrupts_touch_nothing(
        self,
        tmp_path: Path,
        fast_config: Config,
        stages: Any,
        change: Change,
        error: BaseException,
        stage: str,
        key: str,
        value: float,
    ) -> None:
        """What is no result of a stage leaves the folder as it was, results and configuration of the last run."""
        run_pipeline(fast_config, tmp_path)
        before = content(tmp_path)
        stages.failures[stage] = error
        with pytest.raises(type(error)):
            run_pipeline(change(fast_config, **{key: value}), tmp_path)
        assert content(tmp_path) == before

    def test_interrupt_keeps_finished_stages(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """After an interrupt the next run goes on with the stage that was cut off."""
        stages.failures["refine"] = KeyboardInterrupt()
        with pytest.raises(KeyboardInterrupt):
            run_pipeline(fast_config, tmp_path)
        assert summary(tmp_path)["route"]["status"] == "optimal"
        assert summary(tmp_path)["path"] == {"status": "skipped"}
        stages.failures.clear()
        stages.taken()
        run_pipeline(fast_config, tmp_path)
        assert stages.calls == ["refine", "certify", "retime", "figures"]

    @pytest.mark.parametrize(
        "changes",
        [{"task__start__y_m": 2.0}, {"task__goal__mode": "LRL"}, {"machine__links__l2b__stroke_m": [1.2, 1.25]}],
    )
    def test_impossible_task_touches_nothing(
        self, tmp_path: Path, fast_config: Config, stages: Any, change: Change, changes: dict[str, Any]
    ) -> None:
        """A task the machine cannot do is refused before anything is touched."""
        run_pipeline(fast_config, tmp_path)
        before = content(tmp_path)
        with pytest.raises(ConfigError):
            run_pipeline(change(fast_config, **changes), tmp_path)
        assert content(tmp_path) == before
        with pytest.raises(ConfigError):
            run_pipeline(change(fast_config, **changes), tmp_path / "new")
        assert not (tmp_path / "new").exists()

    @pytest.mark.parametrize("moment", [0, 1, 2, 3, 5, 7, 9, 11])
    def test_cut_off_anywhere(
        self,
        tmp_path: Path,
        fast_config: Config,
        stages: Any,
        change: Change,
        monkeypatch: pytest.MonkeyPatch,
        moment: int,
    ) -> None:
        """However files were being moved when the power went, the next run ends with the right results."""
        run_pipeline(fast_config, tmp_path)
        other = change(fast_config, route__step_budget=24)
        stages.objective = 101.0
        replace, left = Path.replace, [moment]

        def fail(self: Path, target: Path) -> Path:
            if left[0] == 0:
                raise KeyboardInterrupt
            left[0] -= 1
            return replace(self, target)

        monkeypatch.setattr(Path, "replace", fail)
        with pytest.raises(KeyboardInterrupt):
            run_pipeline(other, tmp_path)
        monkeypatch.setattr(Path, "replace", replace)
        run_pipeline(other, tmp_path)
        assert open_results(tmp_path, *Stage).route.objective == 101.0
        current = {name for name in files(tmp_path) if not name.startswith("superseded/")}
        assert current == RESULT_FILES | BOOKS
        assert load_config(tmp_path / "config.yaml") == other
        old = [name for name in files(tmp_path) if name.endswith("/route.npz") and name.startswith("superseded")]
        assert len(old) == 1


class TestReading:
    """Results of a run that is over."""

    def run(self, folder: Path, config: Config, **options: Any) -> RunReport:
        """Run into a folder."""
        return run_pipeline(config, folder, **options)

    def test_missing_stage(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """A result that was not made is told."""
        self.run(tmp_path, fast_config, last=Stage.ROUTE)
        with pytest.raises(UsageError, match="no result of refine yet"):
            open_results(tmp_path, Stage.REFINE)
        assert len(open_results(str(tmp_path), Stage.ROUTE).route) == 4

    def test_failed_stage(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """A failed stage has no result, and its reason is told."""
        stages.failures["refine"] = NoSolutionError("refine", "too narrow", "widen")
        with pytest.raises(NoSolutionError):
            self.run(tmp_path, fast_config)
        with pytest.raises(UsageError, match="failed: too narrow"):
            open_results(tmp_path, Stage.REFINE)

    def test_damaged_stage(self, tmp_path: Path, fast_config: Config, stages: Any) -> None:
        """A result that was edited by hand is not taken for the run's."""
        self.run(tmp_path, fast_config)
        (tmp_path / "path.npz").write_bytes(b"mine")
        with pytest.raises(UsageError, match=r"removed or changed after the run: path\.npz"):
            open_results(tmp_path, Stage.REFINE)

    def test_other_period(self, fast_config: Config) -> None:
        """Another period is held against what configurations allow."""
        assert with_retime(fast_config) is fast_config
        assert with_retime(fast_config, period_s=0.004).retime.period_s == 0.004
        with pytest.raises(ConfigError, match=r"a period of 5 s cannot be used:\n.*retime\.period_s"):
            with_retime(fast_config, period_s=5.0)


def test_two_runs_at_once(tmp_path: Path, fast_config: Config, stages: Any) -> None:
    """A run that is started while another is at work there is refused and disturbs nothing."""

    class Second(Quiet):
        def begin(self, stage: Stage) -> Progress:
            with pytest.raises(UsageError, match=f"process {os.getpid()}"):
                run_pipeline(fast_config, tmp_path)
            return super().begin(stage)

    run_pipeline(fast_config, tmp_path, reporter=Second())
    assert stages.calls == ALL
    assert files(tmp_path) == RESULT_FILES | BOOKS
