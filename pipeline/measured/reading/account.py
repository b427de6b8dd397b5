"""What became of every line of a table: read, or skipped for a reason."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from pipeline.arrays import IntArray

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}
"""What separates values, and how it is called."""
_SHOWN_RANGES = 8
"""Number of ranges of lines in a message; JSON has all of them."""


@dataclass(frozen=True)
class Skipped:
    """Lines that hold no row that can be used.

    Attributes
    ----------
    reason : str
        Completes "3 lines ...": "above the header", "with a gap in x1_m", ...
    lines : tuple of int
        Their numbers in the file, counted from 1, increasing.
    rows : bool
        Whether they are rows of the measurement, with gaps.
    """

    reason: str
    lines: tuple[int, ...]
    rows: bool = False

    def __str__(self) -> str:
        count = len(self.lines)
        return f"{count:,} {'line' if count == 1 else 'lines'} {self.reason} ({line_ranges(self.lines, _SHOWN_RANGES)})"


@dataclass(frozen=True, eq=False)
class Account:
    """How a table was read. Lines: `line_count` = header + `row_lines` + all `skipped`.

    Attributes
    ----------
    file : str
        The name of the file, for messages.
    columns : tuple of str
        The columns that were read, by the names asked for.
    encoding : str
        Its characters: UTF-8, UTF-16 or Windows-1252.
    separator, decimal_mark : str
        What separates values; "." or ",".
    line_count, header_line : int
        Number of lines, and the line of the header, counted from 1.
    row_lines : (n,)
        The line of every row read.
    skipped : tuple of Skipped
        All other lines, by reason.
    """

    file: str
    columns: tuple[str, ...]
    encoding: str
    separator: str
    decimal_mark: str
    line_count: int
    header_line: int
    row_lines: IntArray
    skipped: tuple[Skipped, ...]

    @property
    def gap_count(self) -> int:
        """Number of rows that were skipped for a gap."""
        return sum(len(one.lines) for one in self.skipped if one.rows)

    def place(self, row: int) -> str:
        """Say where a row is: file and line."""
        return f"{self.file}, line {int(self.row_lines[row])}"

    def message(self) -> str:
        """Tell a person how the file was read, and what was skipped and why; a line per reason."""
        count, comma = len(self.row_lines), ", decimal commas" if self.decimal_mark == "," else ""
        read = f"{count:,} {'row' if count == 1 else 'rows'} of {', '.join(self.columns)}"
        head = f"{self.file}: {read} ({self.encoding}, {SEPARATORS[self.separator]}{comma})"
        return "\n".join([head, *(f"  skipped: {one}" for one in self.skipped)])

    def as_json(self) -> dict[str, Any]:
        """Give the numbers of rows read and lines skipped for a JSON file; lines as ranges in one text."""
        return {
            "rows": len(self.row_lines),
            "skipped": [
                {"reason": one.reason, "count": len(one.lines), "lines": line_ranges(one.lines)} for one in self.skipped
            ],
        }


def line_ranges(lines: Sequence[int], most: int | None = None) -> str:
    """Write increasing numbers of lines as ranges: 1-3, 7; at most `most` of them."""
    grouped = groupby(lines - np.arange(len(lines), dtype=np.int64))
    ranges, start = [], 0
    for _, group in grouped:
        count = sum(1 for _ in group)
        first, last = lines[start], lines[start + count - 1]
        ranges.append(f"{first}" if count == 1 else f"{first}-{last}")
        start += count
    if most is None or len(ranges) <= most:
        return ", ".join(ranges)
    return f"{', '.join(ranges[:most])} and {len(ranges) - most:,} more places"
