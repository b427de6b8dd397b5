"""Ctrl-C as an exception that is raised once, never within an import, and not lost."""

import math
import signal
import sys
import time
from types import FrameType

_IMPORT_SYSTEM = "<frozen importlib._bootstrap>"
_RETRY_S = 0.02
"""How long an interrupt waits for an import to end, again and again."""
_AGAIN_S = 1.0
"""For how long further interrupts are ignored: the first one is being handled."""
_TURNED_S = 10.0
"""For how long after an interrupt an unforeseen exception is taken for it."""


class Interrupt(KeyboardInterrupt):
    """Ctrl-C, as a class of its own.

    CPython remembers if a plain KeyboardInterrupt leaves code that was given as text (a dataclass created while a
    module is imported), and then ends the process by the signal, even if the exception was handled.
    """


class _Handler:
    """Raises interrupts in the main thread."""

    def __init__(self) -> None:
        self._raised = -math.inf
        self._report_lost = sys.unraisablehook

    def __call__(self, _signal: int, frame: FrameType | None) -> None:
        """Raise an interrupt, unless one was raised just now; within an import, later.

        Modules that are left half way stay so, and libraries turn the exception into others.
        """
        current = signal.getsignal(signal.SIGINT)
        if current is not self and callable(current):
            # An import has ended in code that notes interrupts by itself.
            current(signal.SIGINT, frame)
        elif _is_importing(frame):
            signal.setitimer(signal.ITIMER_REAL, _RETRY_S)
        elif self.raised_for_s() >= _AGAIN_S:
            self._raised = time.monotonic()
            raise Interrupt

    def raised_for_s(self) -> float:
        """Return for how long the last interrupt has been raised; infinity if there was none."""
        return time.monotonic() - self._raised

    def raise_lost(self, lost: "sys.UnraisableHookArgs") -> None:
        """Raise an interrupt again that came where no exception can be raised, such as a finaliser."""
        if issubclass(lost.exc_type, Interrupt):
            self._raised = -math.inf
            signal.setitimer(signal.ITIMER_REAL, _RETRY_S)
        else:
            self._report_lost(lost)


def raise_interrupts() -> None:
    """Raise Ctrl-C as an exception from now on."""
    handler = _Handler()
    sys.unraisablehook = handler.raise_lost
    signal.signal(signal.SIGALRM, handler)
    signal.signal(signal.SIGINT, handler)


def ignore_interrupts() -> None:
    """Ignore Ctrl-C from now on, if it was raised as an exception: the process is ending because of one."""
    if isinstance(signal.getsignal(signal.SIGINT), _Handler):
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def was_interrupted() -> bool:
    """Tell whether Ctrl-C was raised in the last seconds: some libraries turn it into an exception of their own."""
    handler = signal.getsignal(signal.SIGINT)
    return isinstance(handler, _Handler) and handler.raised_for_s() < _TURNED_S


def _is_importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename == _IMPORT_SYSTEM:
            return True
        frame = frame.f_back
    return False
