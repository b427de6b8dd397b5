"""Tables as CSV and back: a header, a row per line, LF line ends, a fixed number of decimals."""

import csv
import io
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from pipeline.export.columns import PER_ACTUATOR, POSE

if TYPE_CHECKING:
    from pipeline.retime.result import TrajectorySamples

DECIMALS = 12
"""At a period of 1 ms, differencing twice multiplies rounding by up to 4e6: twelve decimals leave 2e-6 m/s^2 of it,
six would leave 2 m/s^2, as much as the machine's limit. Shorter periods need more: see `needed_decimals`."""

Column = npt.NDArray[Any]


def trajectory_columns(samples: "TrajectorySamples") -> dict[str, Column]:
    """Name the columns of `trajectory.csv`: time, the actuators' q, qd and qdd, the pose, kappa."""
    columns: dict[str, Column] = {"t_s": samples.t_s}
    for (names, _, _), values in zip(PER_ACTUATOR, (samples.q_m, samples.qd_mps, samples.qdd_mps2), strict=True):
        columns.update(zip(names, values.T, strict=True))
    columns.update(zip(POSE, samples.pose.T, strict=True))
    columns["kappa"] = samples.kappa
    return columns


def format_csv(columns: Mapping[str, npt.ArrayLike], decimals: int = DECIMALS, separator: str = ",") -> str:
    """Write equally long columns of numbers, whole numbers or words, floats with a fixed number of decimals.

    Zero is always written without a sign, and so is what rounds to it.

    Raises
    ------
    ValueError
        When there are no columns, or when they differ in length.
    TypeError
        When a column holds something else.
    """
    if not columns:
        raise ValueError("a table needs at least one column")
    cells = [_cells(name, np.asarray(values), decimals) for name, values in columns.items()]
    if len({len(column) for column in cells}) > 1:
        lengths = ", ".join(f"{name} {len(column)}" for name, column in zip(columns, cells, strict=True))
        raise ValueError(f"all columns must have the same number of rows: {lengths}")
    text = io.StringIO()
    writer = csv.writer(text, delimiter=separator, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*cells, strict=True))
    return text.getvalue()


def read_csv(text: str, separator: str = ",") -> dict[str, Column]:
    """Read a table back: columns of whole numbers as int64, of numbers as float64, all others as words.

    Raises
    ------
    ValueError
        When the table has no header, the same column twice, or a row of another length; names the line.
    """
    reader = csv.reader(io.StringIO(text), delimiter=separator)
    names = next(reader, [])
    if not names or len(set(names)) < len(names):
        raise ValueError(f"line 1 must name every column once, not {','.join(names)!r}")
    rows = []
    for row in reader:
        if len(row) != len(names):
            raise ValueError(f"line {reader.line_num} has {len(row)} values for {len(names)} columns")
        rows.append(row)
    values = zip(*rows, strict=True) if rows else ([] for _ in names)
    return {name: _parse(list(column)) for name, column in zip(names, values, strict=True)}


def _cells(name: str, values: Column, decimals: int) -> list[str]:
    if values.ndim != 1:
        raise TypeError(f"column {name} must be one-dimensional, not of shape {values.shape}")
    if values.dtype.kind == "f":
        rounded = np.where(np.abs(values) <= 0.5 * 10.0**-decimals, 0.0, values)
        return [f"{value:.{decimals}f}" for value in rounded.tolist()]
    if values.dtype.kind in "iuU":
        return [str(value) for value in values.tolist()]
    raise TypeError(f"column {name} must hold numbers or words, not {values.dtype}")


def _parse(cells: list[str]) -> Column:
    if not cells:
        return np.empty(0)
    for dtype in (np.int64, np.float64):
        try:
            return np.array(cells, dtype=dtype)
        except ValueError:
            continue
    return np.array(cells)
