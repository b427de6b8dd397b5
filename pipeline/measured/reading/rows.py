"""The lines around the header of a table: each is read, skipped for a stated reason, or a problem."""

import csv
from array import array
from collections import Counter, defaultdict
from collections.abc import Collection, Iterator
from math import inf, isinf, isnan, nan
from operator import itemgetter

from pipeline.measured.reading.account import SEPARATORS, Skipped
from pipeline.measured.reading.cells import (
    NUMBER,
    ROW,
    DecimalMark,
    clean,
    clean_number,
    is_comment,
    is_gap,
    split_line,
    why_not_a_number,
)
from pipeline.measured.reading.header import Header, header_names
from pipeline.measured.reading.refusal import Problems, shown
from pipeline.measured.reading.units import units_of, wrong_unit

_ABOVE, _UNITS, _BLANK, _COMMENT = "above the header", "of units", "without values", "of comment"
_NOT_A_ROW = "remove the line if it is not a row, or put # before it."


class Rows:
    """Rows below a header, read one line at a time; in columns `may_have_gaps` a gap is a NaN."""

    def __init__(self, file: str, header: Header, may_have_gaps: Collection[str] = ()) -> None:
        self.header = header
        self.may_have_gaps = frozenset(may_have_gaps)
        self.problems = Problems(file)
        self.decimal = DecimalMark()
        self.values, self.lines = array("d"), array("q")
        self.skipped: defaultdict[str, list[int]] = defaultdict(list)
        self.gaps: defaultdict[str, list[int]] = defaultdict(list)
        self.counts: Counter[int] = Counter()
        self.quoted: list[tuple[int, int]] = []
        self.pick = itemgetter(*header.columns.values())

    def add_above(self, lines: list[str]) -> None:
        """Skip the lines above the header; units right above it have to agree, and rows are a problem."""
        self.skipped[_ABOVE] = list(range(1, len(lines) + 1))
        last, last_number = [""], 0
        for number, line in enumerate(lines, 1):
            cells = header_names(line, self.header.separator)
            if cells:
                last, last_number = cells, number
            if len(cells) == len(self.header.names) and self._is_row_of_numbers(line, cells):
                advice = "put the header above all rows, and one measurement in a file."
                self.problems.add(number, "a row above the header.", advice)
        self.check_units(last_number, last)

    def add(self, number: int, line: str) -> None:
        """Read a line, skip it, or take note of what is wrong with it."""
        if not clean(line.replace(self.header.separator, "")):
            self.skipped[_BLANK].append(number)
            return
        try:
            cells = split_line(line, self.header.separator)
        except csv.Error as error:
            if is_comment(line, line.split(self.header.separator)):
                self.skipped[_COMMENT].append(number)
            else:
                self._refuse_quotes(number, error)
            return
        if not any(map(clean, cells)):
            self.skipped[_BLANK].append(number)
        elif is_comment(line, cells):
            self.skipped[_COMMENT].append(number)
        elif not self.counts and self.check_units(number, cells):
            self.skipped[_UNITS].append(number)
        elif self._has_the_columns(number, line, cells):
            self._add_row(number, cells)

    def check_units(self, number: int, cells: list[str]) -> bool:
        """Say whether a line is one of units; those that differ from the names are a problem."""
        units = units_of(cells, self.header.columns)
        if wrong := wrong_unit(units):
            name, unit, expected = wrong
            what = f"the unit is {unit}, but the name of the column says {expected}."
            self.problems.add(number, what, f"convert the values to {expected}, or correct the unit.", name)
        return bool(units)

    def check(self) -> None:
        """Raise the first problem of the file, if it has any."""
        usual = self.counts.most_common(1)[0][0] if self.counts else 0
        for number, count in self.quoted:
            if count != usual:
                self.problems.add(
                    number,
                    f"{count} values, where others have {usual}, and quotes: one quote may have joined two values.",
                    "write the line with matching quotes, or without any.",
                )
        if trouble := self.decimal.trouble():
            (number, column, _), what, advice = trouble
            self.problems.add(number, what, advice, column)
        self.problems.settle()

    def all_skipped(self) -> Iterator[Skipped]:
        """Give the lines that were skipped, by reason."""
        for reason, lines in self.skipped.items():
            if lines:
                yield Skipped(reason, tuple(lines))
        for columns, lines in self.gaps.items():
            yield Skipped(f"with a gap in {columns}", tuple(lines), rows=True)

    def _refuse_quotes(self, number: int, error: csv.Error) -> None:
        if "unexpected end" in str(error):
            what = "a quote is opened and not closed in the same line."
        elif "expected after" in str(error):
            what = "a quote is closed in the middle of a value."
        else:
            what = f"{error}."
        self.problems.add(number, what, "remove the stray quote; a value cannot go on in the next line.")

    def _has_the_columns(self, number: int, line: str, cells: list[str]) -> bool:
        """Require as many values as names: more may be empty, and fewer may only lack columns that are ignored."""
        named, count = len(self.header.names), len(cells)
        self.counts[count] += 1
        if '"' in line:
            self.quoted.append((number, count))
        if count == named:
            return True
        if count > named and not any(map(clean, cells[named:])):
            return True
        if count < named and max(self.header.columns.values()) < count:
            return True
        separated = SEPARATORS[self.header.separator]
        advice = _NOT_A_ROW
        if count > named and self.header.separator == ",":
            advice = "use points for decimals, or separate values by semicolons; " + _NOT_A_ROW
        what = f"{count} {'value' if count == 1 else 'values'}, separated by {separated}, for {named} columns."
        self.problems.add(number, what, advice)
        return False

    def _add_row(self, number: int, cells: list[str]) -> None:
        picked = self.pick(cells)
        if self.decimal.point and ROW.fullmatch("\0".join(picked)):
            values = list(map(float, picked))
            if max(map(abs, values)) < inf:
                self.values.extend(values)
                self.lines.append(number)
                return
        texts = list(self._texts(cells))
        if all(NUMBER.fullmatch(text) or (name in self.may_have_gaps and is_gap(text)) for name, text in texts):
            self._add_numbers(number, texts)
        elif all(text.casefold() == name for name, text in texts):
            what = "the header again: are these two measurements?"
            self.problems.add(number, what, "give one measurement per file, with one header.")
        else:
            self._add_others(number, texts)

    def _add_numbers(self, number: int, texts: list[tuple[str, str]]) -> None:
        values = [nan if is_gap(text) else float(text.replace(",", ".")) for _, text in texts]
        for (name, text), value in zip(texts, values, strict=True):
            if not isnan(value):
                self.decimal.see(number, name, text)
            if isinf(value):
                self.problems.add(number, f"{shown(text)} is too large.", "give numbers in SI units.", name)
        self.values.extend(values)
        self.lines.append(number)

    def _add_others(self, number: int, texts: list[tuple[str, str]]) -> None:
        """Skip a row with gaps; what is neither a number nor a gap is a problem."""
        for name, text in texts:
            if NUMBER.fullmatch(text):
                self.decimal.see(number, name, text)
            elif not is_gap(text):
                what, advice = why_not_a_number(text)
                self.problems.add(number, f"{shown(text)} {what}.", advice, name)
        if gaps := [name for name, text in texts if is_gap(text)]:
            self.gaps[", ".join(gaps)].append(number)

    def _is_row_of_numbers(self, line: str, cells: list[str]) -> bool:
        return not is_comment(line, cells) and all(NUMBER.fullmatch(text) for _, text in self._texts(cells))

    def _texts(self, cells: list[str]) -> Iterator[tuple[str, str]]:
        return ((name, clean_number(cells[index])) for name, index in self.header.columns.items())
