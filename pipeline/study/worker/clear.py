"""Removing the files of runs that need not be kept: a million run folders fill a disk."""

import contextlib
import json
import shutil
from pathlib import Path

from pipeline.artifacts.layout import LOCK, STATE
from pipeline.artifacts.lock import locked
from pipeline.errors import UsageError
from pipeline.regular_file import read_regular_file
from pipeline.study.config import Keep
from pipeline.study.rows import Ending
from pipeline.study.worker.task import ROW

_MOST_BYTES = 2**24


def clear_run(folder: Path, keep: Keep) -> None:
    """Remove all of a run folder but its rows, unless it is to be kept; no other run may need it.

    A folder that another process is writing to, or that cannot be removed, is left as it is, and what is left of one
    is a run folder until it is cleared: the next start of the study comes back to it.
    """
    with contextlib.suppress(OSError, UsageError):
        entries = [entry for entry in folder.iterdir() if not entry.name.startswith(ROW)]
        if not entries or keep is Keep.ALL or (keep is Keep.FAILED and not _all_done(folder)):
            return
        with locked(folder, new=False):
            for entry in entries:
                if entry.is_dir() and not entry.is_symlink():
                    shutil.rmtree(entry)
                elif entry.name not in (LOCK, STATE):
                    entry.unlink(missing_ok=True)
            # In this order: a lock without a state would be taken for another program's.
            (folder / LOCK).unlink(missing_ok=True)
            (folder / STATE).unlink(missing_ok=True)


def _all_done(folder: Path) -> bool:
    """Check that every run that had this folder has a result."""
    files = folder.glob(f"{ROW}*.json")
    return all(json.loads(read_regular_file(file, _MOST_BYTES)).get("ending") == Ending.DONE for file in files)
