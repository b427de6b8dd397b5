"""Columns of numbers from the bytes of a file, with an account of its lines."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.measured.reading.account import Account
from pipeline.measured.reading.decoding import decode_lines
from pipeline.measured.reading.header import Choices, find_header
from pipeline.measured.reading.rows import Rows


@dataclass(frozen=True, eq=False)
class Table:
    """Columns (n,) by the names that were asked for, finite or NaN where gaps may be, and how they were read."""

    columns: Mapping[str, FloatArray]
    account: Account


def read_table(data: bytes, file: str, choices: Choices, gaps: Collection[str] = ()) -> Table:
    """Read the columns of the first choice of names that the header has; `file` is the name for messages.

    The header is the first line that names them all, in any order and case, among others, which are ignored. Values are
    separated as there, by commas, semicolons or tabs, and may be quoted; decimals have a point or a comma throughout.
    Lines above the header, of units that agree with the names, without values, and of comment are skipped, and rows
    with a gap in one of the columns, but for columns that may have `gaps`: there it is a NaN. Everything else that is
    not a row of finite numbers is refused.

    Raises
    ------
    UsageError
        When the file has anything but that; names file, line and column, and what to do.
    """
    lines, encoding = decode_lines(data, file)
    header = find_header(lines, choices, file)
    rows = Rows(file, header, gaps)
    rows.add_above(lines[: header.line_index])
    for index in range(header.line_index + 1, len(lines)):
        rows.add(index + 1, lines[index])
    rows.check()
    values = np.frombuffer(rows.values, dtype=float).reshape(-1, len(header.columns))
    skipped = sorted(rows.all_skipped(), key=lambda one: one.lines)
    account = Account(
        file=file,
        columns=tuple(header.columns),
        encoding=encoding,
        separator=header.separator,
        decimal_mark=rows.decimal.mark,
        line_count=len(lines),
        header_line=header.line_index + 1,
        row_lines=np.frombuffer(rows.lines, dtype=np.int64),
        skipped=tuple(skipped),
    )
    if not len(values):
        raise UsageError("\n".join([f"{file}: the measurement has no rows", *(f"  skipped: {one}" for one in skipped)]))
    return Table(dict(zip(header.columns, values.T.copy(), strict=True)), account)
