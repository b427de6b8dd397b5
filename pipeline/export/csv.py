"""Tables as CSV and back: a header, one row per line, LF line ends, a fixed number of decimals."""

import csv
import io
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

DECIMALS = 12
"""At a period of 1 ms, differencing twice multiplies rounding by up to 4e6: twelve decimals leave 2e-6 m/s^2, six
would leave 2 m/s^2, as much as the machine's limit. Shorter periods need more: see `needed_decimals`."""

Column = npt.NDArray[Any]
"""Values (n,) of a column: numbers or text."""


def format_csv(
    columns: Mapping[str, npt.ArrayLike],
    decimals: int = DECIMALS,
    separator: str = ",",
    *,
    decimal_comma: bool = False,
) -> str:
    """Write equally long columns of numbers or text, floats with a fixed number of decimals.

    Zero, and whatever rounds to it, is written without a sign.

    Raises
    ------
    ValueError
        When there are no columns, or when they differ in length.
    TypeError
        When a column holds something else.
    """
    if not columns:
        raise ValueError("a table needs at least one column")
    cells = [_cells(name, np.asarray(values), decimals, decimal_comma) for name, values in columns.items()]
    if len({len(column) for column in cells}) > 1:
        lengths = ", ".join(f"{name} {len(column)}" for name, column in zip(columns, cells, strict=True))
        raise ValueError(f"all columns must have the same number of rows: {lengths}")
    text = io.StringIO()
    writer = csv.writer(text, delimiter=separator, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*cells, strict=True))
    return text.getvalue()


def read_csv(text: str, separator: str = ",") -> dict[str, Column]:
    """Read a table back: columns of integers that fit as int64, of other numbers as float64, all others as text.

    Raises
    ------
    ValueError
        When the table has no header, the same column twice, a row of another length or none at all; names the line.
    """
    reader = csv.reader(io.StringIO(text), delimiter=separator)
    try:
        names, rows = next(reader, []), []
        if not names or len(set(names)) < len(names):
            raise ValueError(f"line 1 must name every column once, not {','.join(names)!r}")
        for row in reader:
            if len(row) != len(names):
                raise ValueError(f"line {reader.line_num} has {len(row)} values for {len(names)} columns")
            rows.append(row)
    except csv.Error as error:
        raise ValueError(f"line {reader.line_num} is no row of a table: {error}") from None
    values = zip(*rows, strict=True) if rows else ([] for _ in names)
    return {name: _parse(list(column)) for name, column in zip(names, values, strict=True)}


def _cells(name: str, values: Column, decimals: int, decimal_comma: bool) -> list[str]:
    if values.ndim != 1:
        raise TypeError(f"column {name} must be one-dimensional, not of shape {values.shape}")
    if values.dtype.kind == "f":
        rounded = np.where(np.abs(values) <= 0.5 * 10.0**-decimals, 0.0, values)
        cells = [f"{value:.{decimals}f}" for value in rounded.tolist()]
        return [cell.replace(".", ",") for cell in cells] if decimal_comma else cells
    if values.dtype.kind in "iuU":
        return [str(value) for value in values.tolist()]
    raise TypeError(f"column {name} must hold numbers or text, not {values.dtype}")


def _parse(cells: list[str]) -> Column:
    if not cells:
        return np.empty(0)
    for dtype in (np.int64, np.float64):
        try:
            return np.array(cells, dtype=dtype)
        except (ValueError, OverflowError):
            continue
    return np.array(cells)
