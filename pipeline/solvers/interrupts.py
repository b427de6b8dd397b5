"""Ctrl-C during code that would swallow it: solvers report a failed solve, or go on with what they have."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def interrupts_noted() -> Iterator[threading.Event]:
    """Note Ctrl-C in an event instead of raising it, and raise it when the block ends, however it ends.

    Signals only ever reach the main thread: in other threads, and where Ctrl-C is ignored, nothing is noted.

    Raises
    ------
    KeyboardInterrupt
        When the user interrupted.
    """
    interrupted = threading.Event()
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or handler in (signal.SIG_IGN, None):
        yield interrupted
        return

    def note(_signal: int, _frame: FrameType | None) -> None:
        interrupted.set()

    before = signal.signal(signal.SIGINT, note)
    try:
        yield interrupted
    finally:
        signal.signal(signal.SIGINT, before)
        if interrupted.is_set():
            raise KeyboardInterrupt
