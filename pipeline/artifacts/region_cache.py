"""Grid regions cached beside the run folders: costly to compute, and independent of start and goal."""

import contextlib
import os
import re
import stat
from collections.abc import Iterator
from pathlib import Path

from pipeline.artifacts.files import write_whole
from pipeline.artifacts.npz import MOST_BYTES, npz_bytes, read_npz, readable
from pipeline.artifacts.results.regions import pack_regions, unpack_regions
from pipeline.errors import UsageError
from pipeline.route.regions.table import RegionTable

FOLDER = ".regions"
"""Name of the cache in the folder that holds the run folders."""
KEPT = 8
"""Number of tables kept: the most recently used ones."""
_OWN = re.compile(r"[0-9a-f]{64}\.npz|\.[0-9a-f]{1,64}\.[0-9a-f]+\.part")
"""Names of tables, and of what a killed process left of one; all else in the folder is somebody else's."""


def load_grid(runs: Path, key: str, most_bytes: float = MOST_BYTES) -> RegionTable | None:
    """Load the table cached under a key; None if there is none, or it cannot be read.

    Parameters
    ----------
    runs : Path
        The folder that holds the run folders.
    key : str
        Hash of everything the table depends on.
    most_bytes : float
        A larger file is not read.
    """
    path = _path(runs, key)
    if not _is_own(path):
        return None
    try:
        with readable(path):
            table = unpack_regions(read_npz(path, most_bytes))
        os.utime(path)
    except (UsageError, OSError):
        return None
    return table


def keep_grid(runs: Path, key: str, table: RegionTable) -> None:
    """Cache a table under a key, and drop the least recently used ones; a failure to write is ignored.

    Nothing is written through a link, and nothing dropped that is not a table.
    """
    path = _path(runs, key)
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.parent.is_symlink():
            return
        write_whole(path, npz_bytes(pack_regions(table)))
        # Files that a killed process left half written age like all others.
        by_age = sorted(_own_files(path.parent), key=lambda file: file.stat().st_mtime_ns, reverse=True)
        for file in by_age[KEPT:]:
            file.unlink(missing_ok=True)


def _path(runs: Path, key: str) -> Path:
    return runs / FOLDER / f"{key}.npz"


def _own_files(folder: Path) -> Iterator[Path]:
    return (file for file in folder.iterdir() if _OWN.fullmatch(file.name) and _is_own(file))


def _is_own(file: Path) -> bool:
    """Check whether a file is a regular one in a folder: no link, pipe or device, and not in a linked folder."""
    try:
        return stat.S_ISREG(file.lstat().st_mode) and not file.parent.is_symlink()
    except OSError:
        return False
