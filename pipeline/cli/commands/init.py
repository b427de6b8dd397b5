"""The command that writes a configuration to start from."""

import os
import shlex
from collections.abc import Callable, Mapping
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import results_console
from pipeline.errors import UsageError

if TYPE_CHECKING:
    from pipeline.config import Config

_ENDINGS = (".yaml", ".yml")
_SCHEMA = "gantry-tau.schema.json"


class Base(StrEnum):
    """A configuration that comes with the program; its file is named like it."""

    AGDER = "agder"
    QUICK = "quick"
    TINY = "tiny"
    FAST = "fast"
    BODIES = "agder-bodies"
    SPINDLE = "spindle"


_MEANING = {
    Base.AGDER: "the reference machine and task",
    Base.QUICK: "the reference machine and task on a coarse grid",
    Base.TINY: "the reference machine and task on a grid so coarse that the paper's own program can be solved",
    Base.FAST: "the reference machine, driven as fast as a limit of kappa allows",
    Base.BODIES: "the reference machine with bodies: platform, tool, links, carts, rails and posts",
    Base.SPINDLE: "the reference machine with bodies and a spindle ahead of its platform, on a coarse grid",
}


def init(
    name: Annotated[
        Path, typer.Argument(metavar="NAME", help="A new or empty folder, or a new file that ends in .yaml.")
    ],
    base: Annotated[
        Base,
        typer.Option(
            "--base", help="What to start from. " + "; ".join(f"{one}: {text}" for one, text in _MEANING.items()) + "."
        ),
    ] = Base.AGDER,
) -> None:
    """Write a configuration with every key, its value and its meaning, to make one's own from.

    In a folder, the schema with which editors complete the file is beside
    it. Nothing is ever overwritten: exits with 2 if the file is there, or
    the folder has files already (hidden ones do not count).
    """
    from pipeline.config.packaged import packaged_config

    if name.suffix.lower() in _ENDINGS:
        file, beside = name, {}
        config = packaged_config(base, name.stem)
    else:
        from pipeline.config.file import schema_text

        _require_empty(name)
        config = packaged_config(base, name.resolve().name)
        file, beside = name / f"{config.name}.yaml", {name / _SCHEMA: f"{schema_text()}\n"}
    _write({file: _commented(config, base, bool(beside)), **beside})

    console = results_console()
    for written in (file, *beside):
        console.print(f"written: {written}", soft_wrap=True)
    folder = "" if file.parent == Path() else f"cd {shlex.quote(str(file.parent))} && "
    console.print(f"Next: {folder}gantry-tau run {_argument(file.name)}", soft_wrap=True)


def _commented(config: "Config", base: Base, with_schema: bool) -> str:
    from pipeline.config.commented import commented_file

    schema = (f"# yaml-language-server: $schema={_SCHEMA}",) if with_schema else ()
    return commented_file(config, *schema, f"# Started from {base}: {_MEANING[base]}.")


def _argument(file: str) -> str:
    """Quote a file for the shell so that it is not taken for an option."""
    return shlex.quote(f"./{file}" if file.startswith("-") else file)


def _require_empty(folder: Path) -> None:
    if not os.path.lexists(folder):
        return
    if not folder.is_dir():
        raise UsageError(f"{folder} is there already, and not a folder: give another NAME")
    present = sorted(entry.name for entry in folder.iterdir() if not entry.name.startswith("."))
    if present:
        raise UsageError(
            f"{folder} is not empty: it holds {', '.join(present[:3])}{', ...' if len(present) > 3 else ''}. Nothing "
            f"was written.\n  What to change: give another folder, or a file: gantry-tau init {folder / 'my.yaml'}"
        )


def _write(files: Mapping[Path, str]) -> None:
    from pipeline.artifacts.files import write_new

    written: list[Path] = []
    try:
        for path, text in files.items():
            write_new(path, text.encode())
            written.append(path)
    except BaseException as error:
        for path in written:
            path.unlink(missing_ok=True)
        if isinstance(error, FileExistsError):
            raise UsageError(f"{error.filename} is there already, and not overwritten: give another NAME") from None
        raise


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        init,
        (
            "gantry-tau init my-cell    (my-cell/my-cell.yaml, and the schema for editors)",
            "gantry-tau init my-cell.yaml --base quick    (the file alone)",
        ),
    ),
)
"""Every command with its examples."""
