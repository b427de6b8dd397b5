"""Ctrl-C while the command line starts: it ends the process, before anything that loads slowly is imported.

The package imports this module first. In other programs that changes nothing.
"""

import os
import signal
import sys

_COMMAND = "gantry-tau"
_INTERRUPTED = 130
_MESSAGE = b"interrupted: nothing is lost, finished stages are kept\n"


def is_command_line() -> bool:
    """Check whether this process is the command `gantry-tau`, or about to become `python -m pipeline`."""
    name = sys.argv[0] if getattr(sys, "argv", None) else ""
    return name == "-m" or os.path.basename(name) == _COMMAND  # noqa: PTH119  # pathlib loads slowly


def end_at_interrupts() -> bool:
    """End the process at Ctrl-C from now on, unless it is ignored; return whether it is not.

    An exception would not do: within an import it may come out as any other.
    """
    if signal.getsignal(signal.SIGINT) in (signal.SIG_IGN, None):
        return False
    signal.signal(signal.SIGINT, _end)
    return True


def _end(_signal: int, _frame: object) -> None:
    os.write(2, _MESSAGE)
    os._exit(_INTERRUPTED)


if is_command_line():
    end_at_interrupts()
