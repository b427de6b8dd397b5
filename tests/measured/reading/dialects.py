"""Tables written in any dialect of trackers and spreadsheets, and what a reader has to make of each line."""

import codecs
from dataclasses import dataclass, field

import numpy as np

from pipeline.arrays import FloatArray

NAMES = ("t_s", "x1_m", "y1_m", "z1_m", "x2_m", "y2_m", "z2_m")
POSE_NAMES = ("t_s", "x_m", "y_m", "z_m", "rx_rad", "rz_rad")
CHOICES = (NAMES, POSE_NAMES)
BOMS = {
    "utf-8": b"",
    "utf-8-sig": b"",
    "utf-16-le": codecs.BOM_UTF16_LE,
    "utf-16-be": codecs.BOM_UTF16_BE,
    "cp1252": b"",
}


@dataclass(frozen=True)
class Dialect:
    """How a table is written; by default as this package does."""

    separator: str = ","
    mark: str = "."
    encoding: str = "utf-8"
    line_end: str = "\n"
    quoted: bool = False
    padding: str = ""
    preamble: tuple[str, ...] = ()
    units: str | None = None
    blank_lines: bool = False
    comments: bool = False
    last_line_end: bool = True
    trailing_separator: bool = False
    upper_case: bool = False
    order: tuple[int, ...] | None = None
    extra: str | None = None
    gap: str | None = None
    gap_rows: frozenset[int] = field(default_factory=frozenset)
    minus: str = "-"


def write_table(values: FloatArray, dialect: Dialect, names: tuple[str, ...] = NAMES) -> tuple[bytes, list[int]]:
    """Write values (n, k): the bytes of the file, and the line of every row without a gap, counted from 1."""
    order = dialect.order or tuple(range(len(names)))
    header = [names[index].upper() if dialect.upper_case else names[index] for index in order]
    lines = list(dialect.preamble)
    lines.append(_join(header, "note", dialect))
    if dialect.units is not None:
        units = [dialect.units.format(names[index].rsplit("_", 1)[1]) for index in order]
        lines.append(_join(units, "", dialect))
    row_lines = []
    for number, row in enumerate(values):
        if dialect.blank_lines and number % 2:
            lines.append("" if number % 4 == 1 else dialect.separator * (len(names) - 1))
        if dialect.comments and number % 3 == 0:
            lines.append("# the operator's \"note, here;")
        cells = [_number(row[index], dialect) for index in order]
        if dialect.gap is not None and number in dialect.gap_rows:
            cells[number % len(cells)] = dialect.gap
        else:
            row_lines.append(len(lines) + 1)
        lines.append(_join(cells, dialect.extra, dialect))
    if dialect.blank_lines:
        lines += ["", "  "]
    text = dialect.line_end.join(lines) + (dialect.line_end if dialect.last_line_end else "")
    return BOMS[dialect.encoding] + text.encode(dialect.encoding), row_lines


def _number(value: float, dialect: Dialect) -> str:
    return repr(float(value)).replace(".", dialect.mark).replace("-", dialect.minus)


def _join(cells: list[str], extra: str | None, dialect: Dialect) -> str:
    if dialect.extra is not None:
        cells = [*cells[:1], extra or "", *cells[1:]]
    if dialect.quoted or dialect.mark == dialect.separator:
        cells = ['"' + cell.replace('"', '""') + '"' for cell in cells]
    line = (dialect.separator + dialect.padding).join(cells)
    return line + dialect.separator if dialect.trailing_separator else line


def moving(count: int = 5, columns: int = len(NAMES)) -> FloatArray:
    """Make a table (count, columns) of awkward numbers: no column repeats another, and times increase from 0."""
    values = np.random.default_rng(count).normal(0.0, 1.0, (count, columns))
    values[:, 0] = np.arange(count) / 7.0
    values[0, 1], values[-1, 2] = 1e-17, -1.0
    return values
