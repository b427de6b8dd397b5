"""Columns of results by name."""

from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.arrays import FloatArray
from pipeline.artifacts.checked import CheckedArrays
from pipeline.export.trajectory_columns import POSITIONS

CONTROLLED_COLUMNS = ("x_m", "y_m", "z_m", "rx_rad", "rz_rad")
"""Columns of a controlled pose."""
Q_COLUMNS = POSITIONS
"""Columns of the actuator positions."""


def split_columns(names: tuple[str, ...], table: npt.NDArray[Any]) -> dict[str, npt.NDArray[Any]]:
    """Name the columns of a table of shape (n, len(names))."""
    return dict(zip(names, table.T, strict=True))


def stack_columns(arrays: CheckedArrays, names: tuple[str, ...], finite: bool = True) -> FloatArray:
    """Put named columns of shape (n,) side by side, as an array of shape (n, len(names))."""
    return np.stack([arrays.floats(name, "n", finite=finite) for name in names], axis=1)
