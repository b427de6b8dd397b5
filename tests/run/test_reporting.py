"""The report of a run folder: of whatever is there, as a command, and without spoiling the folder."""

import base64
import gzip
import json
from pathlib import Path

import pytest

from pipeline.artifacts import read_state
from pipeline.artifacts.layout import REPORT, failure_report
from pipeline.config import Config
from pipeline.errors import ForwardKinematicsError, NoSolutionError, UsageError
from pipeline.machine import Machine
from pipeline.run import Results, Stage, run_pipeline
from pipeline.run.makers.report_page import report_page
from pipeline.run.reporting import write_report
from tests.cli.calls import invoke
from tests.run.fake_stages import FakeStages


def page_of(config: Config, machine: Machine, folder: Path) -> str:
    """Make the page of a folder with the real results in it."""
    state = read_state(folder)
    assert state is not None
    return report_page(Results(config, machine, folder), state).decode()


def test_a_whole_run(tmp_path: Path, fast_config: Config, machine: Machine, stages: FakeStages) -> None:
    """From loaded results comes a page with the verdict, both motions, the hashes of all files but the figures."""
    stages.run(fast_config, tmp_path)
    page = page_of(fast_config, machine, tmp_path)
    assert "Certified" in page
    numbers = page.split('id="report-data">')[1].split("<")[0]
    assert list(json.loads(gzip.decompress(base64.b64decode(numbers)))["motions"]) == ["refined", "coarse"]
    state = read_state(tmp_path)
    assert state is not None
    assert state.stages[Stage.RETIME].files["trajectory.csv"] in page
    assert "figures/route.png" not in page


def test_a_failed_proof(tmp_path: Path, fast_config: Config, machine: Machine, stages: FakeStages) -> None:
    """A run whose proof broke has a page that says so, by the command too, which ends well itself."""
    stages.failures["certify"] = NoSolutionError("certify", "kappa is beyond its cap at s = 0.3", "plan anew")
    with pytest.raises(NoSolutionError):
        stages.run(fast_config, tmp_path)
    page = page_of(fast_config, machine, tmp_path)
    assert "<title>quick: Not certified</title>" in page
    assert "Kappa is beyond its cap at s = 0.3." in page
    shown = tmp_path / failure_report(Stage.CERTIFY)
    assert shown.exists()
    shown.unlink()
    result = invoke("report", tmp_path, specs=stages.specs)
    assert result.exit_code == 0
    assert shown.exists()
    assert not (tmp_path / REPORT).exists()


def test_it_goes_when_a_new_run_begins(tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
    """The page of a run that failed, or stopped early, does not stay beside the results of the next."""
    stages.run(fast_config, tmp_path, last=Stage.REFINE)
    early = write_report(tmp_path, specs=stages.specs)
    early.write_bytes(b"early")
    stages.failures["retime"] = NoSolutionError("retime", "too heavy", "less load")
    with pytest.raises(NoSolutionError):
        stages.run(fast_config, tmp_path)
    assert not early.exists()
    late = tmp_path / failure_report(Stage.RETIME)
    assert late.exists()
    stages.failures.clear()
    stages.run(fast_config, tmp_path)
    assert early.exists()
    assert not late.exists()
    assert [path.read_bytes() for path in (tmp_path / "superseded").rglob(REPORT)] == [b"early"]


def test_a_page_that_cannot_be_made_hides_no_failure(tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
    """If the report of a failed run fails too, the failure of the run is reported."""
    stages.failures["route"] = NoSolutionError("route", "none", "more")

    def refuse(*_: object) -> bytes:
        raise ForwardKinematicsError(0.1, 3, [0.0] * 6)

    with pytest.raises(NoSolutionError, match="none"):
        run_pipeline(fast_config, tmp_path, specs=stages.with_row(Stage.FIGURES, report=refuse))
    assert not (tmp_path / failure_report(Stage.ROUTE)).exists()
    assert (tmp_path / "failed" / "route.json").exists()


def test_a_summary_of_another_version_is_refused(tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
    """A key that this version reads and that one did not write is named, with what to do."""

    def refuse(*_: object) -> bytes:
        raise KeyError("gap")

    stages.run(fast_config, tmp_path)
    with pytest.raises(UsageError, match=r"written by another version: the summary has no 'gap'\.\n.*run the pipeline"):
        write_report(tmp_path, specs=stages.with_row(Stage.FIGURES, report=refuse))


def test_writing_it_again_spoils_nothing(tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
    """After the command the results are as good as before: nothing is run again."""
    stages.run(fast_config, tmp_path)
    stages.taken()
    (tmp_path / REPORT).unlink()
    assert write_report(tmp_path, specs=stages.specs) == tmp_path / REPORT
    report = stages.run(fast_config, tmp_path)
    assert stages.taken() == []
    assert {outcome.outcome for outcome in report.outcomes} == {"unchanged"}


def test_elsewhere(tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
    """With --output the page goes there, but never over the files of the run."""
    stages.run(fast_config, tmp_path / "run")
    result = invoke("report", tmp_path / "run", "--output", tmp_path / "mine.html", specs=stages.specs)
    assert result.exit_code == 0
    assert (tmp_path / "mine.html").exists()
    inside = tmp_path / "run" / "state.json"
    assert invoke("report", tmp_path / "run", "--output", inside, specs=stages.specs).exit_code == 2


def test_what_cannot_be_reported_on(tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
    """Damaged results, and folders that are none of a run, are refused."""
    with pytest.raises(UsageError, match="does not exist"):
        write_report(tmp_path / "none", specs=stages.specs)
    stages.run(fast_config, tmp_path)
    (tmp_path / "path.csv").write_text("")
    with pytest.raises(UsageError, match=r"path\.csv"):
        write_report(tmp_path, specs=stages.specs)
