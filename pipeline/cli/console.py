"""Where the command line writes: results to stdout, progress and errors to stderr."""

import os
import sys
from typing import TextIO

from rich.console import Console
from rich.text import Text

_PIPE_WIDTH = 110
"""Width of tables that go to a file or a pipe: no table wraps."""


class _Console(Console):
    """A console that leaves broken pipes to the caller."""

    def on_broken_pipe(self) -> None:
        """Raise the error that is being handled."""
        raise  # called by rich from within its `except BrokenPipeError`


def results_console() -> Console:
    """Make the console for results."""
    return _console(stderr=False)


def messages_console() -> Console:
    """Make the console for progress and errors."""
    return _console(stderr=True)


def _console(stderr: bool) -> Console:
    # A new one each time: a console decides about colours when it is made, and streams may have changed.
    console = _Console(stderr=stderr, highlight=False, markup=False, emoji=False)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console = _Console(stderr=stderr, highlight=False, markup=False, emoji=False, width=_PIPE_WIDTH)
    return console


def print_error(message: str) -> None:
    """Write an error message to stderr, with its lines as they are."""
    print_message(Text.assemble(("error: ", "bold red"), message))


def print_message(message: Text | str) -> None:
    """Write a last message to stderr; if that fails, there is nobody to tell."""
    try:
        messages_console().print(message, soft_wrap=True)
    except OSError:
        _discard(sys.stderr)


def discard_output() -> None:
    """Discard what is still to be written to stdout if it cannot be written."""
    try:
        sys.stdout.flush()
    except OSError:
        _discard(sys.stdout)


def _discard(stream: TextIO) -> None:
    """Discard further output: it cannot be written, and Python would complain at exit."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)
