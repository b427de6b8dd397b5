"""Calls in a second process: the same results, whatever becomes of it."""

import math
import operator
import os
import time

import pytest

from pipeline.certify.following.second_process import begun
from pipeline.parallel import THREADS, processors

two = pytest.mark.skipif(processors() < 2, reason="needs a second processor")


def _not_here() -> int:
    raise AssertionError("computed here")


@two
def test_a_call_is_made_in_another_process() -> None:
    """Its result is that of the function, however large what it is given."""
    with begun(os.getpid) as call:
        assert call.result(_not_here) != os.getpid()
    with begun(operator.add, b"a" * 300_000, b"b") as call:
        assert len(call.result(lambda: b"")) == 300_001


def test_without_a_second_processor_there_is_no_other_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """The call is made here, when its result is asked for."""
    monkeypatch.setenv(THREADS, "1")
    with begun(os.getpid) as call:
        assert call.result(os.getpid) == os.getpid()


def test_what_fails_there_is_done_here() -> None:
    """An error is then the caller's."""
    with begun(math.sqrt, -1.0) as call, pytest.raises(ValueError, match=r"math domain|nonnegative"):
        call.result(lambda: math.sqrt(-1.0))
    with begun(os.abort) as call:
        assert call.result(lambda: 3) == 3


@two
def test_an_interrupt_ends_the_process() -> None:
    """Without waiting for what it is doing."""
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt), begun(time.sleep, 600.0):
        raise KeyboardInterrupt
    assert time.monotonic() - began < 300.0
