"""Running stages: all of them or a part, and what the summary says."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pipeline.config import Config
from pipeline.config.file import config_sha256, load_config
from pipeline.errors import (
    NoSolutionError,
    UsageError,
)
from pipeline.machine import Machine
from pipeline.progress import Progress
from pipeline.run import Quiet, Stage, open_results
from tests.run.fake_stages import FakeStages
from tests.run.folders import ALL, BOOKS, RESULT_FILES, content, files, summary

Change = Callable[..., Config]


class TestWhole:
    """A run from nothing."""

    def test_all_files(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """A whole run writes every file of the contract and nothing else."""
        report = stages.run(fast_config, tmp_path / "a" / "b")
        assert stages.calls == ALL
        assert files(tmp_path / "a" / "b") == RESULT_FILES | BOOKS
        assert [outcome.outcome for outcome in report.outcomes] == ["done"] * 6
        assert load_config(tmp_path / "a" / "b" / "config.yaml") == fast_config

    def test_summary(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages, machine: Machine, make: Any
    ) -> None:
        """The summary has every key of the contract, with the figures of the results."""
        report = stages.run(fast_config, tmp_path)
        told = summary(tmp_path)
        assert told == json.loads(json.dumps(report.summary))
        assert told["name"] == "quick"
        assert told["config_sha256"] == config_sha256(fast_config)
        assert {"gantry-tau", "python", "numpy", "scipy", "highspy", "casadi"} <= set(told["versions"])
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
        assert len(told["path"]["quality"]["acceleration_sign_changes"]) == 5
        assert told["path"]["quality"]["motion_s"] == 2.0
        assert "quality" not in trajectory
        assert all(told[part]["seconds"] >= 0.0 for part in ("regions", "route", "path", "trajectory"))

    def test_path_table_gives_the_summary(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """Anyone can recompute the summary's figures from path.csv."""
        from pipeline.export import read_csv

        stages.run(fast_config, tmp_path)
        columns = read_csv((tmp_path / "path.csv").read_text())
        assert len(columns["s"]) == fast_config.refine.check_points
        assert columns["kappa"].max() == pytest.approx(summary(tmp_path)["path"]["kappa_max"], abs=1e-9)

    def test_figures_are_those_of_the_result(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """Results loaded from the folder are those that were made."""
        stages.run(fast_config, tmp_path)
        results = open_results(tmp_path, *list(Stage)[:-1])
        assert len(results.regions) == 5
        assert results.route.objective == 100.0
        assert results.refinement.iterations == 17
        assert results.trajectory.duration_s == 2.0

    def test_verbose_reaches_the_solvers(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """Solvers talk only when asked to."""
        stages.run(fast_config, tmp_path, verbose=True)
        stages.run(fast_config, tmp_path, force=True)
        assert stages.verbose == [True, True, False, False]

    def test_reporter(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """The reporter hears of every stage, and what the stage has to say."""
        heard: list[tuple[Any, ...]] = []

        class Listener:
            def begin(self, stage: Stage) -> Progress:
                heard.append(("begin", str(stage)))
                return lambda message, fraction=None: heard.append((message, fraction))

            def end(self, stage: Stage, outcome: str, seconds: float) -> None:
                heard.append(("end", str(stage), outcome))

        stages.run(fast_config, tmp_path, last=Stage.REGIONS, reporter=Listener())
        stages.run(fast_config, tmp_path, last=Stage.REGIONS, reporter=Listener())
        assert heard == [
            ("begin", "regions"),
            ("working", None),
            ("still working", 0.5),
            ("end", "regions", "done"),
            ("end", "regions", "unchanged"),
        ]
        Quiet().end(Stage.ROUTE, "done", 0.0)


class TestRange:
    """Running a part of the stages."""

    def test_to(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """Stages after the last are not run and the summary says that they were skipped."""
        report = stages.run(fast_config, tmp_path, last=Stage.ROUTE)
        assert stages.calls == ["regions", "route"]
        assert files(tmp_path) == {"regions.npz", "route.npz", "route.csv"} | BOOKS
        assert summary(tmp_path)["path"] == summary(tmp_path)["trajectory"] == {"status": "skipped"}
        assert [outcome.stage for outcome in report.outcomes] == ["regions", "route"]

    def test_to_keeps_later_results_that_still_fit(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages
    ) -> None:
        """Stopping early leaves later results alone while they are up to date."""
        stages.run(fast_config, tmp_path)
        stages.run(fast_config, tmp_path, last=Stage.ROUTE)
        assert files(tmp_path) == RESULT_FILES | BOOKS
        assert summary(tmp_path)["trajectory"]["duration_s"] == 2.0

    def test_to_moves_later_results_that_do_not(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages, change: Change
    ) -> None:
        """Nothing of another configuration stays beside the new one, even if no stage had to run."""
        stages.run(fast_config, tmp_path)
        stages.taken()
        stages.run(change(fast_config, retime__period_s=0.02), tmp_path, last=Stage.REFINE)
        assert stages.calls == []
        assert not {"trajectory.csv", "figures/route.png"} & files(tmp_path)
        assert "superseded/0001/trajectory.csv" in files(tmp_path)
        old = load_config(tmp_path / "superseded" / "0001" / "config.yaml")
        assert old.retime.period_s == 0.01
        assert load_config(tmp_path / "config.yaml").retime.period_s == 0.02
        assert summary(tmp_path)["trajectory"] == {"status": "skipped"}

    def test_from(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """From a stage on, it and the later ones run, on earlier results loaded from the folder."""
        stages.run(fast_config, tmp_path)
        stages.taken()
        stages.run(fast_config, tmp_path, first=Stage.REFINE)
        assert stages.calls == ["refine", "certify", "retime", "figures"]

    def test_from_without_earlier_results(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """Without earlier results there is an error, and no folder is made."""
        with pytest.raises(UsageError, match="there are none in"):
            stages.run(fast_config, tmp_path / "new", first=Stage.REFINE)
        assert not (tmp_path / "new").exists()
        stages.run(fast_config, tmp_path / "new", first=Stage.REGIONS, last=Stage.REGIONS)
        with pytest.raises(UsageError, match="result of route, which has not been run here"):
            stages.run(fast_config, tmp_path / "new", first=Stage.REFINE)

    def test_from_with_outdated_results(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages, change: Change
    ) -> None:
        """Outdated or damaged earlier results are named, and nothing is touched."""
        stages.run(fast_config, tmp_path)
        other = change(fast_config, route__step_budget=24)
        before = content(tmp_path)
        stages.taken()
        with pytest.raises(UsageError, match=r"result of route, which was made with another.*\n.*--to route"):
            stages.run(other, tmp_path, first=Stage.REFINE)
        assert content(tmp_path) == before
        (tmp_path / "path.csv").write_bytes(b"mine")
        with pytest.raises(UsageError, match=r"removed or changed since \(path\.csv\)"):
            stages.run(fast_config, tmp_path, first=Stage.RETIME)
        assert stages.calls == []

    def test_from_after_failure(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """A failed stage is nothing to build on."""
        stages.failures["route"] = NoSolutionError("route", "none", "more")
        with pytest.raises(NoSolutionError):
            stages.run(fast_config, tmp_path)
        with pytest.raises(UsageError, match="result of route, which failed"):
            stages.run(fast_config, tmp_path, first=Stage.REFINE)

    def test_empty_range(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """A range that ends before it begins is refused."""
        with pytest.raises(UsageError, match="--from refine comes after --to route"):
            stages.run(fast_config, tmp_path, first=Stage.REFINE, last=Stage.ROUTE)
        assert files(tmp_path) == set()


def test_two_runs_at_once(tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
    """A run that is started while another is at work there is refused and disturbs nothing."""

    class Second(Quiet):
        def begin(self, stage: Stage) -> Progress:
            with pytest.raises(UsageError, match=f"process {os.getpid()}"):
                stages.run(fast_config, tmp_path)
            return super().begin(stage)

    stages.run(fast_config, tmp_path, reporter=Second())
    assert stages.calls == ALL
    assert files(tmp_path) == RESULT_FILES | BOOKS
