"""Values of a table: numbers with a decimal point or comma, gaps, and what is neither."""

import csv
import re
from dataclasses import dataclass

from pipeline.measured.reading.refusal import INVISIBLE

NUMBER = re.compile(r"[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?", re.ASCII)
"""A number with at most one mark, whether it separates decimals or thousands; `float` reads more than that."""
_WITH_POINT = r"\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\s*"
ROW = re.compile(rf"{_WITH_POINT}(?:\0{_WITH_POINT})*", re.ASCII)
"""Numbers with a point or none, blanks around them, joined by zero bytes: most rows of most files, told at once."""
_MAYBE_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:[.,'\u2019\s]\d{3})+(?:[.,]\d*)?")
_EXCEL_ERROR = re.compile(r"#[A-Z0-9\u00c4\u00d6\u00dc/]+[!?]?")
_CLOCK = re.compile(r"(?:\d+[-/.]\d+[-/.]\d+[T ]*)?\d+:\d+(?::\d+(?:[.,]\d*)?)?Z?|\d{4}-\d\d-\d\d")
_LEADING_NUMBER = re.compile(r"[+-]?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?\s*[^\d\s.,]+")
_DASHES = frozenset("-\u2010\u2011\u2012\u2013\u2014\u2015\u2212")
_GAPS = frozenset(
    ("nan", "+nan", "-nan", "nan(ind)", "-nan(ind)", "nan(snan)", "1.#ind", "-1.#ind", "1.#qnan", "-1.#qnan")
    + ("n/a", "na", "#n/a", "#n/a n/a", "#na", "#nv", "#n/d", "n.a.", "<na>", "null", "none", "nil")
    + ("missing", "invalid", ".", "?", "*")
)
_INFINITE = frozenset(("inf", "infinity", "1.#inf", "\u221e"))
_PLAIN_NUMBERS = "give numbers in SI units, without units beside them; for a gap leave the value empty, or write NaN."


def split_line(line: str, separator: str) -> list[str]:
    """Split a line into values, of which any may be quoted; blanks after a separator are skipped.

    Raises
    ------
    csv.Error
        When a quote is not closed within the line, or closed within a value.
    """
    return next(csv.reader((line,), delimiter=separator, strict=True, skipinitialspace=True), [])


def clean(cell: str) -> str:
    """Remove blanks at the ends, and characters without width anywhere."""
    return cell.strip() if cell.isascii() else INVISIBLE.sub("", cell).strip()


def clean_number(cell: str) -> str:
    """Clean a value, and write a minus sign as the hyphen it stands for."""
    return cell.strip() if cell.isascii() else clean(cell).replace("\u2212", "-")


def is_gap(cell: str) -> bool:
    """Recognise a clean value that says that there is none: empty, dashes, NaN, #N/A, ..."""
    return not cell or _DASHES.issuperset(cell) or cell.casefold() in _GAPS


def is_comment(line: str, cells: list[str]) -> bool:
    """Recognise a line that is not a row: it begins with # or % or //, but not with a value of Excel such as #N/A."""
    if not line.lstrip().startswith(("#", "%", "//")):
        return False
    return len(cells) < 2 or not _EXCEL_ERROR.fullmatch(clean(cells[0]))


def why_not_a_number(cell: str) -> tuple[str, str]:
    """Say what is wrong with a clean value that is neither a number nor a gap, and what to change."""
    if cell.casefold().lstrip("+-") in _INFINITE:
        return "is not finite", "leave the value empty where nothing was measured, or remove the row."
    if _THOUSANDS.fullmatch(cell):
        return "has separators of thousands", "write numbers without them: 1234.5 or 1234,5."
    if _CLOCK.fullmatch(cell):
        return "is a time of day or a date", "give seconds since the start of the motion, as a number."
    if _EXCEL_ERROR.fullmatch(cell):
        return "is an error of a spreadsheet", "mend the formula; for a gap leave the value empty, or write #N/A."
    if _LEADING_NUMBER.fullmatch(cell):
        return "is a number with something behind it", _PLAIN_NUMBERS
    return "is not a number", _PLAIN_NUMBERS


@dataclass
class DecimalMark:
    """Which mark the numbers of a file have, by the first examples: (line, column, text) each.

    Attributes
    ----------
    point, comma : tuple or None
        The first number with that mark.
    certain_comma : bool
        A comma was seen that cannot separate thousands.
    """

    point: tuple[int, str, str] | None = None
    comma: tuple[int, str, str] | None = None
    certain_comma: bool = False

    def see(self, line: int, column: str, text: str) -> None:
        """Take note of a number."""
        if "." in text:
            self.point = self.point or (line, column, text)
        elif "," in text:
            self.comma = self.comma or (line, column, text)
            self.certain_comma = self.certain_comma or not _MAYBE_THOUSANDS.fullmatch(text)

    @property
    def mark(self) -> str:
        """The mark, "." if there are whole numbers only."""
        return "," if self.comma else "."

    def trouble(self) -> tuple[tuple[int, str, str], str, str] | None:
        """Say where numbers contradict each other or may mean two things, what is wrong, and what to change."""
        if self.comma is None:
            return None
        text = self.comma[2]
        if self.point is not None:
            other_line, other_column, other = self.point
            return (
                self.comma,
                f"'{text}' has a comma, but '{other}' in line {other_line}, column {other_column}, has a point.",
                "use one decimal mark in the whole file, and no separators of thousands.",
            )
        if not self.certain_comma:
            whole, thousandths = text.split(",")
            return (
                self.comma,
                f"'{text}' may mean {whole}.{thousandths} or {whole}{thousandths}, as may every other comma of the "
                "file: decimals or thousands cannot be told.",
                "write decimal points, or decimal commas with another number of decimals, and no separators of "
                "thousands.",
            )
        return None
