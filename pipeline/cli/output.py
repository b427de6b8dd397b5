"""Results as a command was asked for them: tables, files and pictures."""

import io
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


def refuse_inside(output: Path | None, run: Path) -> None:
    """Refuse to write into the folder of a run.

    Raises
    ------
    UsageError
        When the file would be inside.
    """
    if output is not None and output.resolve().is_relative_to(run.resolve()):
        raise UsageError(f"{output} is inside {run}, whose files are not overwritten: give another --output")


def check_picture(path: Path | None, option: str = "--picture") -> None:
    """Refuse a picture whose name has no known ending, before anything is computed.

    Raises
    ------
    UsageError
        When the ending is none of `PICTURES`.
    """
    if path is not None and path.suffix.lower().lstrip(".") not in PICTURES:
        endings = ", ".join(f".{name}" for name in PICTURES)
        raise UsageError(f"{option} {path}: the name of the file must end in one of {endings}")


def save_picture(figure: "Figure", path: Path) -> None:
    """Write a figure completely or not at all."""
    from pipeline.artifacts import write_whole

    buffer = io.BytesIO()
    figure.savefig(buffer, format=path.suffix.lower().lstrip("."))
    write_whole(path, buffer.getvalue())
