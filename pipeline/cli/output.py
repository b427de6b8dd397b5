"""Results as a command was asked for them: tables, files and pictures."""

import io
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.table import Table

from pipeline.errors import UsageError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES = ("png", "pdf", "svg")
"""Endings of pictures, without the dot."""


def text_table(title: str, header: Sequence[str], rows: Iterable[Sequence[str]], words: Sequence[int] = (0,)) -> Table:
    """Make a table whose columns `words` are text, and all others numbers."""
    table = Table(title=title, title_justify="left")
    for index, heading in enumerate(header):
        table.add_column(heading, justify="left" if index in words else "right")
    for row in rows:
        table.add_row(*row)
    return table


def check_output(path: Path | None, option: str = "--output") -> None:
    """Refuse a file that must not or cannot be written, before anything is computed.

    Raises
    ------
    UsageError
        When it is inside a run folder.
    OSError
        When it is a folder, or may not be written.
    """
    if path is None:
        return
    from pipeline.artifacts.output import check_writable, is_written_through
    from pipeline.artifacts.state import is_of_a_run

    check_writable(path)
    if is_written_through(path):
        return
    for folder in Path(os.path.realpath(path)).parents:
        if is_of_a_run(folder):
            raise UsageError(f"{path} is inside {folder}, whose files are not overwritten: give another {option}")


def check_picture(path: Path | None, option: str = "--picture") -> None:
    """Refuse a picture whose name has no known ending, or that must not or cannot be written.

    Raises
    ------
    UsageError
        When the ending is none of `PICTURES`, or the file is inside a run folder.
    OSError
        When it is a folder, or may not be written.
    """
    if path is not None and path.suffix.lower().lstrip(".") not in PICTURES:
        endings = ", ".join(f".{name}" for name in PICTURES)
        raise UsageError(f"{option} {path}: the name of the file must end in one of {endings}")
    check_output(path, option)


def refuse_same(one: Path | None, other: Path | None, options: str) -> None:
    """Refuse two files that are one: the second would overwrite the first.

    Raises
    ------
    UsageError
        When they are the same file.
    """
    if one is not None and other is not None and os.path.realpath(one) == os.path.realpath(other):
        raise UsageError(f"{options} are the same file, {one}: give two")


def save_picture(figure: "Figure", path: Path) -> None:
    """Write a figure completely or not at all."""
    from pipeline.artifacts.output import write_output

    buffer = io.BytesIO()
    figure.savefig(buffer, format=path.suffix.lower().lstrip("."))
    write_output(path, buffer.getvalue())
