"""The lock of a run folder: one run at a time writes to it."""

import contextlib
import fcntl
import os
import re
from collections.abc import Iterator
from pathlib import Path

from pipeline.artifacts.files import naming
from pipeline.artifacts.layout import LOCK, STATE
from pipeline.errors import LockedError, UsageError

_PROCESS = re.compile(rb"[0-9]{0,20}")
"""What a lock holds: the number of the process that holds it, or held it last."""


@contextlib.contextmanager
def locked(folder: Path, new: bool, state: str = STATE) -> Iterator[None]:
    """Hold the lock of a run folder.

    Parameters
    ----------
    new : bool
        It was not a run folder before: a lock that is already there belongs to a run that has just begun, or to
        another program.
    state : str
        The file that makes it a run folder.

    Raises
    ------
    LockedError
        When another run holds it; nothing was changed.
    UsageError
        When the file is another program's; nothing was changed.
    """
    file = folder / LOCK
    descriptor, created = _open(file)
    try:
        _hold(folder, descriptor, "run")
        content = os.pread(descriptor, 64, 0)
        if not _PROCESS.fullmatch(content) or (new and not created and not (folder / state).exists()):
            raise UsageError(
                f"{file} is not the lock of a run, but another program's: nothing was changed.\n"
                "  What to change: give another folder with --out, or move that file away."
            )
        _sign(descriptor)
        yield
    finally:
        # What did not become a run folder is left as it was.
        if created and not (folder / state).exists():
            file.unlink(missing_ok=True)
        os.close(descriptor)


@contextlib.contextmanager
def locked_study(folder: Path) -> Iterator[None]:
    """Hold the lock of the folder of a study, which is left there: one client at a time leads it.

    Raises
    ------
    LockedError
        When another client holds it; nothing was changed.
    """
    descriptor, _ = _open(folder / LOCK)
    try:
        _hold(folder, descriptor, "study")
        _sign(descriptor)
        yield
    finally:
        os.close(descriptor)


def _sign(descriptor: int) -> None:
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, str(os.getpid()).encode(), 0)


def _hold(folder: Path, descriptor: int, what: str) -> None:
    try:
        with naming(folder / LOCK):
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        process = os.pread(descriptor, 64, 0).decode(errors="replace").strip()
        raise LockedError(
            f"another {what} (process {process or 'unknown'}) is writing to {folder}.\n"
            "  What to change: wait until it ends, or give another folder with --out."
        ) from None


def _open(file: Path) -> tuple[int, bool]:
    """Open the file, but not through a link, and say whether it was created."""
    flags = os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
    with contextlib.suppress(FileExistsError):
        return os.open(file, flags | os.O_CREAT | os.O_EXCL, 0o666), True
    return os.open(file, flags), False
