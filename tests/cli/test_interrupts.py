"""Ctrl-C as an exception."""

import importlib
import signal
import sys
import time
from pathlib import Path

import pytest

from pipeline.cli.interrupts import Interrupt, ignore_interrupts, raise_interrupts, was_interrupted
from pipeline.solvers.interrupts import interrupts_noted

IMPORTED = """
import signal, time
signal.raise_signal(signal.SIGINT)
time.sleep(0.1)
whole = True
"""


@pytest.fixture(autouse=True)
def raised(interrupts_as_before: None) -> None:
    """Raise interrupts."""
    raise_interrupts()


def test_it_is_raised_once() -> None:
    """Further ones, while the first is being handled, are ignored."""
    with pytest.raises(Interrupt):
        signal.raise_signal(signal.SIGINT)
    signal.raise_signal(signal.SIGINT)


def test_it_is_known_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    """An exception that a library has made of it is taken for it, and later ones are not."""
    assert not was_interrupted()
    with pytest.raises(Interrupt):
        signal.raise_signal(signal.SIGINT)
    assert was_interrupted()
    later = time.monotonic() + 60.0
    monkeypatch.setattr(time, "monotonic", lambda: later)
    assert not was_interrupted()


def test_it_waits_for_an_import(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The module is imported as a whole, and the exception is raised afterwards."""
    (tmp_path / "interrupted_module.py").write_text(IMPORTED)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(Interrupt):
        _import_and_wait()
    assert sys.modules.pop("interrupted_module").whole


def _import_and_wait() -> None:
    importlib.import_module("interrupted_module")

    time.sleep(10.0)


def test_it_is_not_lost(capsys: pytest.CaptureFixture[str]) -> None:
    """Where no exception can be raised it waits, too, and nothing is printed."""

    class Finalised:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGINT)

    one = Finalised()
    del one
    with pytest.raises(Interrupt):
        time.sleep(10.0)
    assert capsys.readouterr() == ("", "")


def test_it_is_noted_where_that_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An import that ends in code that notes interrupts does not break it."""
    (tmp_path / "interrupted_module.py").write_text("import signal\nsignal.raise_signal(signal.SIGINT)\n")
    monkeypatch.syspath_prepend(tmp_path)
    reached = False
    importlib.import_module("interrupted_module")

    with pytest.raises(KeyboardInterrupt), interrupts_noted() as noted:
        reached = noted.wait(10.0)
    assert reached
    del sys.modules["interrupted_module"]


def test_it_is_ignored_at_the_end() -> None:
    """A process that ends because of an interrupt is not interrupted again."""
    ignore_interrupts()
    signal.raise_signal(signal.SIGINT)
