"""Where the command line writes: results to stdout, progress and errors to stderr."""

import os

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
    console = messages_console()
    console.print(Text.assemble(("error: ", "bold red"), message), soft_wrap=True)
