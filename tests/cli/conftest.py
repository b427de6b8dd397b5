"""Fixtures of the command line: those of runs, a way to call it, and a configuration as a file."""

import signal
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from pipeline.config import Config
from pipeline.config.file import dump_config
from tests.cli.calls import Call, invoke
from tests.run.conftest import *  # noqa: F403  # fixtures are found by their names here
from tests.run.fake_stages import FakeStages


@pytest.fixture(autouse=True)
def interrupts_as_before() -> Iterator[None]:
    """Restore what becomes of interrupts, which the command line changes for the process it runs in."""
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGALRM)}
    hook = sys.unraisablehook
    yield
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    sys.unraisablehook = hook
    for number, handler in handlers.items():
        signal.signal(number, handler)


@pytest.fixture(autouse=True)
def empty_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Run every command in an empty folder."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def call(stages: FakeStages) -> Call:
    """Call the command line in this process, with fake stages."""
    return partial(invoke, specs=stages.specs)


@pytest.fixture
def config_file(tmp_path: Path, fast_config: Config) -> Path:
    """Write a configuration, named `quick`."""
    path = tmp_path / "machine.yaml"
    path.write_text(dump_config(fast_config))
    return path
