"""Where the command line writes: results to stdout, progress and errors to stderr.

Keys, names and file names come from files of others. What a terminal would obey in them is shown as an escape
instead, and so is what the terminal's encoding does not have.
"""

import os
import re
import sys
from collections.abc import Iterable
from typing import Any, TextIO

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

_PIPE_WIDTH = 110
"""Width of tables that go to a file or a pipe: no table wraps."""


_OBEYED = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")
"""Control characters but tab and newline, and what turns the direction of writing."""


class _Console(Console):
    """A console that shows control characters instead of sending them, and leaves broken pipes to the caller."""

    def render_str(self, text: str, **options: Any) -> Text:
        """Make text of a string, which is measured as it is shown."""
        return super().render_str(printable(text, self.encoding), **options)

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Render to segments whose text is only text."""
        for segment in super().render(renderable, options):
            yield segment if segment.control else Segment(printable(segment.text, self.encoding), segment.style)

    def on_broken_pipe(self) -> None:
        """Raise the error that is being handled."""
        raise  # called by rich from within its `except BrokenPipeError`


def printable(text: str, encoding: str = "utf-8") -> str:
    """Replace what a terminal would obey, or cannot show in its encoding, by backslash escapes."""
    if text.isascii() and not _OBEYED.search(text):
        return text
    try:
        # Bytes of file names that are not in the locale's encoding.
        text = text.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")
    except UnicodeEncodeError:
        text = text.encode("utf-8", "backslashreplace").decode("utf-8")
    shown = _OBEYED.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), text)
    return shown.encode(encoding, "backslashreplace").decode(encoding)


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
