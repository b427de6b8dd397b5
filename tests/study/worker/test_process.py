"""A worker has a process of its own run each case, and stops it when its time is up."""

import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.study.config import Keep
from pipeline.study.program import program_version
from pipeline.study.worker.clear import clear_run
from pipeline.study.worker.process import Process, ProcessEndedError, run_request
from pipeline.study.worker.task import known_row
from tests.study.fakes import cases_of


@pytest.fixture
def tiny_config() -> Config:
    """The configuration with the coarsest grid."""
    return load_config(Path(__file__).parents[3] / "configs" / "tiny.yaml")


@pytest.fixture(scope="module")
def process() -> Iterator[Process]:
    """Start a process that runs cases, for all tests here."""
    started = Process(threads=1)
    yield started
    started.end()


def request(folder: Path, config: Config, **keys: Any) -> dict[str, Any]:
    """Ask for the regions of a tiny grid."""
    case = next(iter(cases_of(folder, config)))
    asked = {"key": case.key, "data": case.data, "to": "regions", "folder": str(folder / "runs" / case.folder)}
    rest = {
        "time_limit_s": 120.0,
        "threads": 1,
        "why_not": False,
        "again": False,
        "program": program_version(),
    }
    return {**asked, **rest, **keys}


def test_a_run_leaves_its_folder_and_its_row(tmp_path: Path, tiny_config: Config, process: Process) -> None:
    """The row is on disk when the answer comes, and is the answer to the same request from then on."""
    asked = request(tmp_path, tiny_config)
    row = process.ask(asked)
    assert (row["ending"], row["figures"]["regions.status"]) == ("done", "done")
    assert (Path(asked["folder"]) / "regions.npz").exists()
    known = known_row(asked)
    assert known is not None
    assert known.data() == row == run_request(asked)["row"]
    assert known_row({**asked, "again": True}) is None


@pytest.mark.parametrize("keep", [Keep.NONE, Keep.FAILED])
def test_a_folder_need_not_be_kept(tmp_path: Path, tiny_config: Config, process: Process, keep: Keep) -> None:
    """The row is, and it is known from then on; what is cleared can be run again."""
    asked = request(tmp_path, tiny_config)
    assert process.ask(asked)["ending"] == "done"
    clear_run(Path(asked["folder"]), keep)
    assert not (Path(asked["folder"]) / "regions.npz").exists()
    assert known_row(asked) is not None
    assert process.ask({**asked, "again": True})["ending"] == "done"


def test_figures_of_an_earlier_attempt_are_not_taken(tmp_path: Path, tiny_config: Config, process: Process) -> None:
    """An attempt that does not come to the twin has none of its figures."""
    asked = request(tmp_path, tiny_config)
    twin = Path(asked["folder"]) / f"twin-{asked['key'][:16]}.json"
    twin.parent.mkdir(parents=True)
    twin.write_text('{"simulate": {"peak_force_n": 1.0}}')
    assert "simulate.peak_force_n" not in process.ask({**asked, "again": True})["figures"]
    assert not twin.exists()


def test_a_process_that_does_not_start_is_tried_again() -> None:
    """It is no run that took too long."""
    process = Process(threads=1, start_s=0.0)
    with pytest.raises(ProcessEndedError, match="did not start in 0 s"):
        process.ask({"time_limit_s": 9.0})
    process.end()


def test_a_configuration_that_is_refused_is_a_row(tmp_path: Path, tiny_config: Config, process: Process) -> None:
    """With the reason, and without a trace of a run."""
    asked = request(tmp_path, tiny_config)
    asked["data"]["task"]["start"]["rx_deg"] = 60.0
    row = process.ask(asked)
    assert (row["ending"], row["reason"]) == ("refused", "not possible as configured")
    assert "task.start.rx_deg" in row["message"]


def test_the_process_has_as_many_threads_as_it_may(process: Process) -> None:
    """BLAS and our own are told, so that workers do not take each other's processors."""
    environment = psutil.Process(process.pid).environ()
    assert {environment[name] for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "GANTRY_TAU_THREADS")} == {"1"}


def test_another_program_does_not_run_it(tmp_path: Path, tiny_config: Config) -> None:
    """It says which one it is."""
    assert run_request(request(tmp_path, tiny_config, program="0.0.9")) == {"other": program_version()}


def test_time_that_is_up_is_a_row(tmp_path: Path, quick_config: Config) -> None:
    """Whatever a solver is doing, its process is stopped."""
    asked = request(tmp_path, quick_config, to="retime", time_limit_s=0.3)
    row = run_request(asked)["row"]
    assert (row["ending"], row["reason"]) == ("time limit", "time limit")
    assert row["seconds"] >= 0.3
    assert known_row(asked) is not None
    assert known_row({**asked, "time_limit_s": 9.0}) is None


def test_a_process_that_is_killed_is_said(tmp_path: Path, quick_config: Config) -> None:
    """The worker lives on, and says how its process ended."""
    process = Process(threads=1)
    threading.Timer(0.2, os.kill, (process.pid, signal.SIGKILL)).start()
    with pytest.raises(ProcessEndedError, match="SIGKILL, as for lack of memory"):
        process.ask(request(tmp_path, quick_config, to="retime"))
    assert not process.lives
    process.end()


def test_the_process_ends_with_its_worker() -> None:
    """No run goes on that nobody waits for."""
    read, write = os.pipe()
    if (worker := os.fork()) == 0:
        os.write(write, f"{Process(threads=1).pid}\n".encode())
        os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(worker, 0)
    child = int(os.read(read, 64))
    until = time.monotonic() + 30.0
    while psutil.pid_exists(child) and psutil.Process(child).status() != psutil.STATUS_ZOMBIE:
        assert time.monotonic() < until
        time.sleep(0.05)
