"""Failed stages leave a diagnosis, and no result."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.errors import (
    ConfigError,
    ConfigIssue,
    ForwardKinematicsError,
    NoSolutionError,
    UnfitConfigError,
    UsageError,
)
from pipeline.run import Stage, open_results
from tests.run.fake_stages import FakeStages
from tests.run.folders import BOOKS, RESULT_FILES, content, files, summary

Change = Callable[..., Config]


class TestFailure:
    """Failed stages leave a diagnosis, and no result."""

    def test_no_solution(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """Reason, advice and diagnosis are kept and in the summary; later parts are skipped."""
        diagnosis = {"status": "infeasible", "cut": np.arange(3), "bound": np.inf}
        stages.failures["refine"] = NoSolutionError("refine", "no way", "widen it", diagnosis)
        with pytest.raises(NoSolutionError) as caught:
            stages.run(fast_config, tmp_path)
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

    def test_other_failures_of_a_stage(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """A failure without advice of its own is kept with its message."""
        stages.failures["retime"] = ForwardKinematicsError(0.1, 3, [0.0] * 6)
        with pytest.raises(ForwardKinematicsError):
            stages.run(fast_config, tmp_path)
        part = summary(tmp_path)["trajectory"]
        assert part["status"] == "failed"
        assert "did not converge for entry 3" in part["reason"]

    def test_a_failed_way_back_leaves_the_way_there(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages
    ) -> None:
        """The motion is a result, the failed part is reported every time, and no file of an older way back stays."""
        stages.run(fast_config, tmp_path).require_complete()
        stages.no_way_back = NoSolutionError("retime", "on the way back, c2 is too weak", "a stronger one")
        report = stages.run(fast_config, tmp_path, first=Stage.RETIME)
        for again in (report, stages.run(fast_config, tmp_path)):
            with pytest.raises(NoSolutionError, match=r"on the way back, c2 is too weak\n.*a stronger one") as caught:
                again.require_complete()
            assert caught.value.exit_code == 1
        told = summary(tmp_path)["trajectory"]
        assert (told["status"], told["back"]["status"]) == ("done in part", "failed")
        assert (told["back"]["reason"], told["back"]["advice"]) == ("on the way back, c2 is too weak", "a stronger one")
        kept = files(tmp_path)
        assert {"trajectory.csv", "trajectory.npz", "figures/route.png"} <= kept
        assert not {"trajectory_back.csv", "trajectory_back.json"} & kept

    def test_a_run_that_ends_with_a_missing_part_has_a_report(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages
    ) -> None:
        """As a failed one has; one that goes on to the end has its own. The error says where it is."""
        stages.no_way_back = NoSolutionError("retime", "on the way back, c2 is too weak", "a stronger one")
        for last, page in ((Stage.RETIME, "failed/retime.html"), (Stage.FIGURES, "report.html")):
            report = stages.run(fast_config, tmp_path / last, last=last)
            with pytest.raises(NoSolutionError) as caught:
                report.require_complete()
            assert caught.value.__notes__ == [f"A report of the run is in {tmp_path / last / page}"]
            assert {name for name in files(tmp_path / last) if name.endswith(".html")} == {page}

    def test_a_trajectory_too_long_to_write_leaves_nothing_stale(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages, change: Change
    ) -> None:
        """What was asked for cannot be had: the rows of another configuration do not stay in its place."""
        stages.run(fast_config, tmp_path)
        stages.failures["retime"] = UnfitConfigError("retime", "retime.period_s makes too many rows", "Raise it.")
        with pytest.raises(UnfitConfigError, match="too many rows"):
            stages.run(change(fast_config, retime__speed=0.000_02), tmp_path)
        kept = files(tmp_path)
        assert "trajectory.csv" not in kept
        assert "superseded/0001/trajectory.csv" in kept
        assert summary(tmp_path)["trajectory"]["status"] == "failed"
        assert summary(tmp_path)["path"]["status"] == "converged"

    def test_failure_supersedes_old_results(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages, change: Change
    ) -> None:
        """After a failure nothing looks like the result of it or of a later stage, and nothing is lost."""
        stages.run(fast_config, tmp_path)
        stages.failures["route"] = NoSolutionError("route", "none", "more")
        with pytest.raises(NoSolutionError):
            stages.run(change(fast_config, route__step_budget=5), tmp_path)
        kept = files(tmp_path)
        assert kept & RESULT_FILES == {"regions.npz"}
        assert {f"superseded/0001/{name}" for name in RESULT_FILES - {"regions.npz"}} <= kept

    def test_failure_is_tried_again_and_forgotten(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages
    ) -> None:
        """A failed stage runs again every time; once it works its old diagnosis moves aside."""
        stages.failures["route"] = NoSolutionError("route", "none", "more")
        for _ in range(2):
            with pytest.raises(NoSolutionError):
                stages.run(fast_config, tmp_path)
        assert stages.taken() == ["regions", "route", "route"]
        stages.failures.clear()
        stages.run(fast_config, tmp_path)
        assert stages.calls == ["route", "refine", "certify", "retime", "figures"]
        current = {name for name in files(tmp_path) if not name.startswith("superseded/")}
        assert current == RESULT_FILES | BOOKS
        assert any(name.endswith("failed/route.json") for name in files(tmp_path))

    def test_failure_of_another_configuration_is_not_told(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages, change: Change
    ) -> None:
        """A failure belongs to its configuration like a result does."""
        stages.failures["refine"] = NoSolutionError("refine", "none", "more")
        with pytest.raises(NoSolutionError):
            stages.run(fast_config, tmp_path)
        stages.run(change(fast_config, refine__nodes=90), tmp_path, last=Stage.ROUTE)
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
        stages: FakeStages,
        change: Change,
        error: BaseException,
        stage: str,
        key: str,
        value: float,
    ) -> None:
        """An error that is not a result of a stage leaves results and configuration of the last run as they were."""
        stages.run(fast_config, tmp_path)
        before = content(tmp_path)
        stages.failures[stage] = error
        with pytest.raises(type(error)):
            stages.run(change(fast_config, **{key: value}), tmp_path)
        assert content(tmp_path) == before

    def test_interrupt_keeps_finished_stages(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """After an interrupt the next run goes on with the stage that was cut off."""
        stages.failures["refine"] = KeyboardInterrupt()
        with pytest.raises(KeyboardInterrupt):
            stages.run(fast_config, tmp_path)
        assert summary(tmp_path)["route"]["status"] == "optimal"
        assert summary(tmp_path)["path"] == {"status": "skipped"}
        stages.failures.clear()
        stages.taken()
        stages.run(fast_config, tmp_path)
        assert stages.calls == ["refine", "certify", "retime", "figures"]

    @pytest.mark.parametrize(
        "changes",
        [{"task__start__y_m": 2.0}, {"task__goal__mode": "LRL"}, {"machine__links__l2b__stroke_m": [1.2, 1.25]}],
    )
    def test_impossible_task_touches_nothing(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages, change: Change, changes: dict[str, Any]
    ) -> None:
        """A task the machine cannot do is refused before anything is touched."""
        stages.run(fast_config, tmp_path)
        before = content(tmp_path)
        with pytest.raises(ConfigError):
            stages.run(change(fast_config, **changes), tmp_path)
        assert content(tmp_path) == before
        with pytest.raises(ConfigError):
            stages.run(change(fast_config, **changes), tmp_path / "new")
        assert not (tmp_path / "new").exists()

    @pytest.mark.parametrize("moment", [0, 1, 2, 3, 5, 7, 9, 11])
    def test_cut_off_anywhere(
        self,
        tmp_path: Path,
        fast_config: Config,
        stages: FakeStages,
        change: Change,
        monkeypatch: pytest.MonkeyPatch,
        moment: int,
    ) -> None:
        """However files were being moved when the power went, the next run ends with the right results."""
        stages.run(fast_config, tmp_path)
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
            stages.run(other, tmp_path)
        monkeypatch.setattr(Path, "replace", replace)
        stages.run(other, tmp_path)
        assert open_results(tmp_path, *Stage).route.objective == 101.0
        current = {name for name in files(tmp_path) if not name.startswith("superseded/")}
        assert current == RESULT_FILES | BOOKS
        assert load_config(tmp_path / "config.yaml") == other
        old = [name for name in files(tmp_path) if name.endswith("/route.npz") and name.startswith("superseded")]
        assert len(old) == 1
