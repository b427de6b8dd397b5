"""Grid regions kept by content beside the run folders: dear to compute, and the same whatever start and goal are."""

import contextlib
import os
from pathlib import Path

from pipeline.artifacts.files import write_whole
from pipeline.artifacts.pack import npz_bytes, pack_regions, read_npz, readable, unpack_regions
from pipeline.errors import UsageError
from pipeline.route.regions.table import RegionTable

FOLDER = ".regions"
"""Where the tables are, in the folder that holds the run folders."""
KEPT = 8
"""How many tables stay: those that were used last."""


def load_grid(runs: Path, key: str) -> RegionTable | None:
    """Load the table that was kept under this key; None where there is none, or none that can be read.

    Parameters
    ----------
    runs : Path
        The folder that holds the run folders.
    key : str
        Hash of all that the table depends on.
    """
    path = _path(runs, key)
    try:
        with readable(path):
            table = unpack_regions(read_npz(path))
        os.utime(path)
    except (UsageError, OSError):
        return None
    return table


def keep_grid(runs: Path, key: str, table: RegionTable) -> None:
    """Keep a table under this key, and the tables used last beside it; the run goes on where that fails."""
    path = _path(runs, key)
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, npz_bytes(pack_regions(table)))
        # Whatever a killed process left half written grows old like all others.
        by_age = sorted(path.parent.iterdir(), key=lambda file: file.stat().st_mtime_ns, reverse=True)
        for file in by_age[KEPT:]:
            file.unlink(missing_ok=True)


def _path(runs: Path, key: str) -> Path:
    return runs / FOLDER / f"{key}.npz"
