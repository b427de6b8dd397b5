"""Results as a command was asked for them: tables, files and pictures."""

import io
import json
import os
from collections.abc import Callable, Iterable, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.table import Table

from pipeline.errors import UsageError
from pipeline.regular_file import read_regular_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES = ("png", "pdf", "svg")
"""Endings of pictures, without the dot."""
_FACTS = ".json"
_MOST_FACTS_BYTES = 2**24


def text_table(title: str, header: Sequence[str], rows: Iterable[Sequence[str]], words: Sequence[int] = (0,)) -> Table:
    """Make a table whose columns `words` are text, and all others numbers."""
    table = Table(title=title, title_justify="left")
    for index, heading in enumerate(header):
        table.add_column(heading, justify="left" if index in words else "right")
    for row in rows:
        table.add_row(*row)
    return table


def print_json(data: dict[str, Any]) -> None:
    """Print plain data as JSON, unrounded."""
    from pipeline.artifacts import json_bytes

    typer.echo(json_bytes(data), nl=False)


def check_output(output: Path | None, run: Path | None = None, option: str = "--output") -> None:
    """Refuse a file that must not or cannot be written, before anything is computed.

    Parameters
    ----------
    run : Path, optional
        The run folder that a command reads: nothing is written into it.

    Raises
    ------
    UsageError
        When it is inside that folder, or a result of another run.
    OSError
        When it is a folder, or may not be written; names it.
    """
    if output is None:
        return
    from pipeline.artifacts.output import check_writable, is_written_through

    check_writable(output)
    if is_written_through(output):
        return
    target = Path(os.path.realpath(output))
    if run is not None and target.is_relative_to(os.path.realpath(run)):
        raise UsageError(f"{output} is inside {run}, whose files are not overwritten: give another {option}")
    for folder in target.parents:
        if _is_result(target.relative_to(folder).as_posix(), folder):
            raise UsageError(f"{output} is a result of the run in {folder}, and not overwritten: give another {option}")


def check_facts(output: Path, belongs: Callable[[dict[str, Any]], bool], run: Path | None = None) -> Path | None:
    """Check where output goes; give the name of the file beside it that says how it was made, if there is one.

    Raises
    ------
    UsageError
        When the output must not be written, see `check_output`, has the ending of such a file, or one is there already
        that does not belong to output of this kind.
    """
    from pipeline.artifacts.output import is_written_through

    check_output(output, run)
    if is_written_through(output):
        return None
    if output.suffix == _FACTS:
        raise UsageError(
            f"--output {output}: a {_FACTS} file beside the output says how it was made: give another ending"
        )
    facts = output.with_suffix(_FACTS)
    if os.path.lexists(facts) and not _is_of_output(facts, belongs):
        raise UsageError(
            f"--output {output}: {facts} would say how the output was made, but is there already, and says something "
            "else: give another name"
        )
    return facts


def _is_of_output(facts: Path, belongs: Callable[[dict[str, Any]], bool]) -> bool:
    try:
        value = {} if facts.is_symlink() else json.loads(read_regular_file(facts, _MOST_FACTS_BYTES))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(value, dict) and belongs(value)


def _is_result(name: str, folder: Path) -> bool:
    """Check whether a name, relative to a folder, is that of a result of a run there."""
    from pipeline.artifacts.layout import BOOKS, SUPERSEDED
    from pipeline.artifacts.state import is_of_a_run
    from pipeline.run.stage_specs import SPECS

    names = (*BOOKS, f"{SUPERSEDED}/*", *(pattern for spec in SPECS for pattern in spec.patterns))
    return any(fnmatchcase(name, pattern) for pattern in names) and is_of_a_run(folder)


def check_picture(path: Path | None, run: Path | None = None, option: str = "--picture") -> None:
    """Refuse a picture whose name has no known ending, or that must not or cannot be written.

    Raises
    ------
    UsageError
        When the ending is none of `PICTURES`, or the file must not be written, see `check_output`.
    OSError
        When it is a folder, or may not be written.
    """
    if path is not None and path.suffix.lower().lstrip(".") not in PICTURES:
        endings = ", ".join(f".{name}" for name in PICTURES)
        raise UsageError(f"{option} {path}: the name of the file must end in one of {endings}")
    check_output(path, run, option)


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
