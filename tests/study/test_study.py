"""Studies on real workers: killed, interrupted, led twice; in the end the table is that of a calm one."""

import contextlib
import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Timer

import psutil
import pytest

from pipeline.artifacts.lock import locked_study
from pipeline.config import Config
from pipeline.errors import LockedError, UsageError
from pipeline.study.cases import build_cases
from pipeline.study.config import parse_study
from pipeline.study.rows import Row
from pipeline.study.study import STUDY, Workers, report_study, run_study
from pipeline.study.worker.task import keep_row, run_case
from tests.benchmarks.study_kills import ROOT, environment, run_with_kills, table, write_study
from tests.study.fakes import study_file


@pytest.mark.slow
def test_kills_change_nothing(tmp_path: Path) -> None:
    """Client, scheduler and workers are killed at random moments; a calm study gives the same table but for times."""
    study = write_study(tmp_path, count=1)
    assert len(run_with_kills(study, tmp_path / "killed", kills=2, seed=4, pause_s=3.0)) <= 2
    calm = tmp_path / "calm"
    outcome = run_study(study, calm, Workers(count=1))
    assert table(calm) == table(tmp_path / "killed")
    assert sorted(outcome.table.columns["reason"], key=str) == [None, None, "no route", "no route"]
    again = run_study(calm / STUDY, calm, Workers(scheduler="tcp://127.0.0.1:9"))
    assert again.table.columns == outcome.table.columns
    (calm / "report.html").unlink()
    assert report_study(calm).table.columns == outcome.table.columns
    assert (calm / "report.html").exists()


def living(group: int) -> list[int]:
    """List the processes of a group that live; those that nobody has waited for do not."""
    found = []
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error, ProcessLookupError):
            if os.getpgid(process.pid) == group and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process.pid)
    return found


@pytest.mark.slow
def test_an_interrupted_study_goes_on(tmp_path: Path) -> None:
    """Ctrl-C to all processes of the terminal ends it with 130, leaves a table, and no process behind."""
    study = write_study(tmp_path, count=50)
    command = [sys.executable, "-m", "pipeline", "study", str(study), "--out", str(tmp_path / "out"), "--workers", "1"]
    process = subprocess.Popen(
        command, cwd=ROOT, env=environment(), start_new_session=True, stderr=subprocess.PIPE, text=True
    )
    rows = tmp_path / "out" / "runs"
    until = time.monotonic() + 120.0
    while len(list(rows.glob("*/row-*.json"))) < 3:
        assert time.monotonic() < until
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)
    _, error = process.communicate(timeout=60)
    assert process.returncode == 130, error
    assert "Traceback" not in error
    with (tmp_path / "out" / "study.csv").open() as file:
        assert len(list(csv.DictReader(file))) < 200
    while living(process.pid):
        assert time.monotonic() < until + 60.0
        time.sleep(0.1)


def test_two_clients_do_not_lead_one_study(tmp_path: Path, quick_config: Config) -> None:
    """The second is refused, and changes nothing."""
    study, folder = study_file(tmp_path, quick_config), tmp_path / "out"
    folder.mkdir()
    (folder / "study.sqlite").touch()
    with locked_study(folder), pytest.raises(LockedError, match=r"another study \(process \d+\) is writing to"):
        run_study(study, folder, Workers(count=1))
    assert sorted(path.name for path in folder.iterdir()) == [".lock", "study.sqlite"]


def test_a_folder_of_something_else_is_refused(tmp_path: Path, quick_config: Config) -> None:
    """Nothing is written to it."""
    study, folder = study_file(tmp_path, quick_config), tmp_path / "out"
    folder.mkdir()
    (folder / "mine.txt").touch()
    with pytest.raises(UsageError, match="not the folder of a study"):
        run_study(study, folder, Workers(count=1))
    with pytest.raises(UsageError, match="not the folder of a study"):
        report_study(folder)
    assert [path.name for path in folder.iterdir()] == ["mine.txt"]


@pytest.mark.parametrize("names", [[".lock"], ["study.yaml", "base.yaml", "runs"]])
def test_a_folder_of_a_study_without_its_rows_is_taken(tmp_path: Path, quick_config: Config, names: list[str]) -> None:
    """After a kill at the very start, and where the file of the rows was moved away: it comes to the workers."""
    folder = tmp_path / "out"
    folder.mkdir()
    for name in names:
        (folder / name).touch()
    with pytest.raises(UsageError, match="workers need"):
        run_study(study_file(tmp_path, quick_config), folder, Workers(count=1_000_000))
    assert (folder / "study.csv").exists()


def test_a_scheduler_that_is_none_is_said(tmp_path: Path, quick_config: Config) -> None:
    """In seconds, and without a trace of Dask's."""
    with pytest.raises(UsageError, match=r"no scheduler answers at tcp://127\.0\.0\.1:9"):
        run_study(study_file(tmp_path, quick_config), tmp_path / "out", Workers(scheduler="tcp://127.0.0.1:9"))


def test_a_run_that_another_worker_has_begun_is_waited_for(tmp_path: Path) -> None:
    """What it leaves is taken: nothing is done twice."""
    folder = tmp_path / "runs" / "1"
    folder.mkdir(parents=True)
    request = {"key": "k" * 64, "folder": str(folder), "time_limit_s": 9.0, "again": False, "to": "route"}
    row = Row("k" * 64, "done", time_limit_s=9.0)
    base = ROOT / "configs" / "tiny.yaml"
    parameters = [{"key": "task.tilt_max_deg", "values": [30]}]
    study = parse_study({"base": str(base), "parameters": parameters})
    request["data"] = next(iter(build_cases(study, tmp_path / "s.yaml", "1"))).data
    with locked_study(folder):
        Timer(0.2, keep_row, (request, row)).start()
        assert run_case({**request, "program": "1", "why_not": False}) == row
