"""The second process beside a run."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import pipeline
from pipeline.artifacts import read_run_folder
from pipeline.config import Config
from pipeline.figures import FIGURES
from pipeline.machine import build_machine
from pipeline.progress import Monitor
from pipeline.run import Results
from pipeline.run.beside.process import SecondProcess
from pipeline.run.makers.figures import make_figures
from pipeline.stage import STAGES, Stage
from tests.run.fake_stages import FakeStages

needs_two = pytest.mark.skipif(
    not hasattr(os, "sched_getaffinity") or len(os.sched_getaffinity(0)) < 2, reason="there is one processor"
)


@pytest.fixture
def folder(fast_config: Config, change: Callable[..., Config], stages: FakeStages, tmp_path: Path) -> Path:
    """Make a run folder that lacks nothing but figures, with a time law that needs no solver."""
    stages.run(change(fast_config, retime__jerk=False), tmp_path / "run", last=Stage.RETIME)
    return tmp_path / "run"


@needs_two
def test_figures_and_report_are_the_same(folder: Path) -> None:
    """In two processes or in one: the same files, to the byte, in order; none is written, every figure is counted."""
    config, _ = read_run_folder(folder)
    machine = build_machine(config.machine)
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    with SecondProcess(folder) as beside:
        beside.begin(config)
        for stage in STAGES[:-1]:
            beside.done(stage)
        # The first figure is made there, and so is the report.
        there = {name: beside.files(name) for name in ("report.html", FIGURES[0].name)}
        said, watch = _listener()
        both = make_figures(Results(config, machine, folder, beside=beside), watch)
    said_alone, watch = _listener()
    alone = make_figures(Results(config, machine, folder), watch)
    assert list(both.files) == list(alone.files)
    assert {name: alone.files[name] == content for name, content in both.files.items()} == dict.fromkeys(
        both.files, True
    )
    for files in there.values():
        assert files is not None
        assert files.items() <= alone.files.items()
    counted = [f"figure {i} of {len(FIGURES)}" for i in range(1, len(FIGURES) + 1)]
    for messages in (said, said_alone):
        assert [message.split(",")[0] for message in messages] == [*counted, "writing the report"]
        assert {message.split(", ")[1] for message in messages[:-1]} == {row.name for row in FIGURES}
    assert {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()} == before


def _listener() -> tuple[list[str], Monitor]:
    """Give a list of messages, and what adds to it."""
    messages: list[str] = []
    return messages, Monitor(lambda message, fraction=None: messages.append(message))


@needs_two
def test_a_part_is_made_once(folder: Path) -> None:
    """What the run has taken the process leaves out, and what the process has begun the run does not get."""
    config, _ = read_run_folder(folder)
    taken = {"report.html", *(row.name for row in FIGURES[1:])}
    with SecondProcess(folder) as beside:
        assert all(beside.take(name) for name in sorted(taken))
        for stage in STAGES[:-1]:
            beside.done(stage)
        beside.begin(config)
        assert beside.files(FIGURES[0].name) is not None
        assert not beside.take(FIGURES[0].name)
        assert [beside.files(name) for name in taken] == [None] * len(taken)


@needs_two
def test_a_failure_is_no_answer(quick_config: Config, tmp_path: Path) -> None:
    """Where there is nothing to draw, the run is left to find out and to say so."""
    with SecondProcess(tmp_path / "missing") as beside:
        beside.begin(quick_config)
        beside.done(Stage.ROUTE)
        assert beside.files("machine") is None
        assert beside.take("machine")


def test_without_one_there_is_no_answer(tmp_path: Path) -> None:
    """A run that began none, or could not, draws by itself."""
    with SecondProcess(tmp_path) as beside:
        beside.done(Stage.REGIONS)
        assert beside.take("regions")
        assert beside.files("regions") is None


@needs_two
def test_it_ends_with_the_run(quick_config: Config, tmp_path: Path) -> None:
    """Interrupted or failed: no process is left, nor waited for."""

    def interrupted() -> None:
        with SecondProcess(tmp_path) as beside:
            beside.begin(quick_config)
            assert _children() > before
            raise KeyboardInterrupt

    before = _children()
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert _children() <= before


def _children() -> set[str]:
    """Number the processes that this one has begun, those included that nobody waited for."""
    return {number for file in Path("/proc/self/task").glob("*/children") for number in file.read_text().split()}


def test_it_ends_when_the_run_is_killed(tmp_path: Path) -> None:
    """Its input ends with the run, however that ends."""
    package = Path(pipeline.__file__).parents[1]
    ended = subprocess.run(
        [sys.executable, "-P", "-m", "pipeline.run.beside", str(tmp_path)],
        env={**os.environ, "PYTHONPATH": str(package)},
        input=b"",
        capture_output=True,
        timeout=300,
        check=False,
    )
    assert (ended.returncode, ended.stdout) == (1, b"")
