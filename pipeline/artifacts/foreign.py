"""What is not a run's to touch: links, pipes and devices under the names of its files, and files that others wrote."""

import os
import stat
from collections.abc import Iterable
from pathlib import Path, PurePosixPath

from pipeline.artifacts.layout import BOOKS, LOCK, STATE, existing_files
from pipeline.artifacts.state import is_of_a_run
from pipeline.errors import UsageError
from pipeline.regular_file import file_kind


def refuse_no_folder(path: Path) -> None:
    """Refuse a path at which there is something, but not a folder.

    Raises
    ------
    UsageError
        When it is a file, or a link that leads to none.
    """
    if os.path.lexists(path) and not path.is_dir():
        kind = file_kind(path.lstat().st_mode).replace("a regular file", "a file")
        leads = " that leads nowhere" if path.is_symlink() and not path.exists() else ""
        raise UsageError(f"{path} is {kind}{leads}; --out needs a folder")


def refuse_links(folder: Path, names: Iterable[str]) -> None:
    """Refuse to write files through links: all have to be regular files in folders, as far as they exist.

    Parameters
    ----------
    names : iterable of str
        Names of files relative to the folder; of a pattern, only the folder that it is for has to be one.

    Raises
    ------
    UsageError
        When one is not.
    """
    for name in names:
        path = PurePosixPath(name)
        for parent in list(path.parents)[-2::-1]:
            _require(folder / parent, stat.S_IFDIR)
        if "*" not in path.name:
            _require(folder / path, stat.S_IFREG)


def refuse_other_content(folder: Path, what: str) -> None:
    """Refuse a folder that holds anything but a lock, and so is not to become one of an atlas or a tour.

    Raises
    ------
    UsageError
        When there is something else in it.
    """
    found = sorted(entry.name for entry in folder.iterdir()) if folder.is_dir() else []
    if found not in ([], [LOCK]):
        raise UsageError(
            f"{folder} already holds {', '.join(found[:3])}, but no {what}: nothing was changed.\n"
            "  What to change: give another folder with --out."
        )


def refuse_foreign(folder: Path, reserved: Iterable[str]) -> None:
    """Refuse a folder that no run has written, but in which files have the names of results.

    Raises
    ------
    UsageError
        When there are such files.
    """
    if foreign := existing_files(folder, (*BOOKS, *reserved)):
        raise UsageError(
            f"{folder} already holds {', '.join(foreign[:3])}, but is not a run folder (it has no {STATE}): nothing "
            "was changed.\n  What to change: give another folder with --out, or move these files away."
        )


def refuse_foreign_state(folder: Path, error: UsageError) -> None:
    """Refuse a folder whose state cannot be read, unless its summary shows that it is the folder of a run.

    Raises
    ------
    UsageError
        When it is not.
    """
    if not is_of_a_run(folder):
        why = str(error).partition("\n")[0]
        raise UsageError(
            f"{why} Nothing was changed.\n  What to change: give another folder with --out, or move that file away."
        ) from None


def _require(path: Path, kind: int) -> None:
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return
    if stat.S_IFMT(mode) != kind:
        raise UsageError(
            f"{path} is {file_kind(mode)}, where a run needs {file_kind(kind)}: nothing is written through it, or in "
            "its place.\n  What to change: move it away, or give another folder with --out."
        )
