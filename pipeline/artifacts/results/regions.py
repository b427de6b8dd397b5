"""The region table as a file: `regions.npz`, one array per column."""

from typing import Any

import numpy.typing as npt

from pipeline.artifacts.checked import CheckedArrays
from pipeline.artifacts.layout import REGIONS_NPZ
from pipeline.artifacts.npz import Arrays, npz_bytes, read_npz, readable
from pipeline.artifacts.results.columns import CONTROLLED_COLUMNS, Q_COLUMNS, split_columns, stack_columns
from pipeline.artifacts.results.saved import SavedRun
from pipeline.machine.geometry import MODES
from pipeline.route.regions.table import RegionTable

_ARMS, _ENDS = 3, 2


def regions_files(table: RegionTable) -> dict[str, bytes]:
    """Write the region table."""
    return {REGIONS_NPZ: npz_bytes(pack_regions(table))}


def load_regions(run: SavedRun) -> RegionTable:
    """Load the region table of a run."""
    file = run.folder / REGIONS_NPZ
    with readable(file):
        return unpack_regions(read_npz(file, 1e9 * run.config.route.memory_gb))


def pack_regions(table: RegionTable) -> dict[str, npt.NDArray[Any]]:
    """Give one array of shape (n,) per column of the region table."""
    return {
        **split_columns(CONTROLLED_COLUMNS, table.controlled),
        "ry_rad": table.ry_rad,
        "mode": table.modes,
        "gate": table.gates,
        **split_columns(Q_COLUMNS, table.q_m),
        "kappa": table.kappa,
        "det_sign": table.det_sign,
        "link_distance_m": table.link_distance_m,
        "x_min_m": table.x_window_m[:, 0],
        "x_max_m": table.x_window_m[:, 1],
        "visit": table.visits,
    }


def unpack_regions(arrays: Arrays) -> RegionTable:
    """Rebuild the region table from its columns.

    Raises
    ------
    ValueError
        When one is missing, or is not a column of such a table.
    """
    checked = CheckedArrays(arrays)
    if len(checked.whole("mode", "n")) < _ENDS:
        raise ValueError("it has no rows for start and goal")
    same_name = ("ry_rad", "kappa", "det_sign", "link_distance_m")
    return RegionTable(
        controlled=stack_columns(checked, CONTROLLED_COLUMNS),
        q_m=stack_columns(checked, Q_COLUMNS),
        x_window_m=stack_columns(checked, ("x_min_m", "x_max_m"), finite=False),
        modes=checked.whole("mode", "n", most=len(MODES) - 1),
        gates=checked.whole("gate", "n", most=_ARMS),
        visits=checked.whole("visit", "n"),
        **{name: checked.floats(name, "n", finite=False) for name in same_name},
    )
