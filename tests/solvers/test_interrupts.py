"""Ctrl-C is noted while a block runs, and raised when it ends."""

import signal
import threading

import pytest

from pipeline.solvers import interrupts_noted


def test_an_interrupt_waits_for_the_end_of_the_block() -> None:
    """Nothing is raised within; the handler is the one from before afterwards."""
    before, after = signal.getsignal(signal.SIGINT), []
    with pytest.raises(KeyboardInterrupt), interrupts_noted() as interrupted:
        signal.raise_signal(signal.SIGINT)
        after.append(interrupted.is_set())
    assert after == [True]
    assert signal.getsignal(signal.SIGINT) is before


def test_an_interrupted_block_that_fails_was_interrupted() -> None:
    """What fails because it was interrupted is not reported as a failure; other failures are."""
    with pytest.raises(KeyboardInterrupt), interrupts_noted():
        signal.raise_signal(signal.SIGINT)
        raise ArithmeticError
    with pytest.raises(ArithmeticError), interrupts_noted():
        raise ArithmeticError


def test_other_threads_are_left_alone() -> None:
    """Only the main thread may set handlers; elsewhere the block just runs."""
    ran = []

    def work() -> None:
        with interrupts_noted() as interrupted:
            ran.append(interrupted.is_set())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert ran == [False]


def test_where_interrupts_are_ignored_they_stay_so() -> None:
    """In the background of a script nothing is noted, and nothing raised."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interrupts_noted() as interrupted:
            signal.raise_signal(signal.SIGINT)
        assert not interrupted.is_set()
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
