"""Pictures that a command was asked for, in the format that the file's name ends with."""

import io
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.errors import UsageError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "pdf", "svg")
"""Endings of pictures, without the dot."""


def check_picture(path: Path | None, option: str = "--picture") -> None:
    """Refuse, before anything is computed, a picture whose name has no known ending.

    Raises
    ------
    UsageError
        When the ending is none of `FORMATS`.
    """
    if path is not None and path.suffix.lower().lstrip(".") not in FORMATS:
        endings = ", ".join(f".{name}" for name in FORMATS)
        raise UsageError(f"{option} {path}: the file's name has to end in one of {endings}")


def save_picture(figure: "Figure", path: Path) -> None:
    """Write a figure whole or not at all."""
    from pipeline.artifacts import write_whole

    buffer = io.BytesIO()
    figure.savefig(buffer, format=path.suffix.lower().lstrip("."))
    write_whole(path, buffer.getvalue())
