"""The header of a table: the first line that names all columns asked for, whatever separates them."""

import csv
import difflib
import re
from collections.abc import Sequence
from typing import NamedTuple

from pipeline.measured.reading.account import SEPARATORS
from pipeline.measured.reading.cells import NUMBER, clean, clean_number, split_line
from pipeline.measured.reading.refusal import INVISIBLE, refusal, shown, strange_characters

Choices = Sequence[tuple[str, ...]]
"""Lists of column names, any of which will do; the first that is complete is taken."""

_SEARCHED, _COMPARED = 200, 200
"""Numbers of lines, and of names in a line, that are searched for what is nearest to a header, for the message."""
_LISTED = 20
_ALIKE = 0.6


class Header(NamedTuple):
    """A header: its line counted from 0, the separator, all names as they are, and where the columns are."""

    line_index: int
    separator: str
    names: list[str]
    columns: dict[str, int]


def find_header(lines: list[str], choices: Choices, file: str) -> Header:
    """Find the first line that names all columns of one of the choices.

    Raises
    ------
    UsageError
        When there is none: says which line is nearest, what it lacks, and which of its names differ and how.
    """
    for index, line in enumerate(lines):
        folded = line.casefold() if line.isascii() else INVISIBLE.sub("", line).casefold()
        if not any(all(name in folded for name in choice) for choice in choices):
            continue
        for separator in SEPARATORS:
            names = header_names(line, separator)
            if names and (columns := _columns(names, choices)):
                _refuse_twice(names, columns, file, index + 1)
                return Header(index, separator, names, columns)
    raise _no_header(lines, choices, file)


def match_columns(names: Sequence[str], choices: Choices) -> dict[str, str]:
    """Find the columns of the first complete choice among names: by name asked for, the name as it is.

    Blanks at the ends, characters without width and case do not matter.

    Raises
    ------
    ValueError
        When no choice is complete: says what is lacking, and which names differ and how.
    """
    columns = _columns(names, choices)
    if not columns:
        raise ValueError(_lacking(names, choices))
    return {name: names[index] for name, index in columns.items()}


def header_names(line: str, separator: str) -> list[str]:
    """Split a line as a header; a # or % before it is no part of it. Empty where quotes do not match."""
    try:
        return split_line(re.sub(r"^[\s\ufeff]*(#+|%+|//)\s*", "", line), separator)
    except csv.Error:
        return []


def _normal(name: str) -> str:
    return clean(name).casefold()


def _columns(names: Sequence[str], choices: Choices) -> dict[str, int]:
    """Find the first complete choice: where each of its columns is, or nothing."""
    places: dict[str, int] = {}
    for index, name in enumerate(names):
        places.setdefault(_normal(name), index)
    for choice in choices:
        if all(name in places for name in choice):
            return {name: places[name] for name in choice}
    return {}


def _refuse_twice(names: list[str], columns: dict[str, int], file: str, line: int) -> None:
    normal = [_normal(name) for name in names]
    for name in columns:
        if normal.count(name) > 1:
            places = " and ".join(str(index + 1) for index, one in enumerate(normal) if one == name)
            raise refusal(file, f"{name} is named {normal.count(name)} times, as columns {places}.", "keep one.", line)


def _lacking(names: Sequence[str], choices: Choices) -> str:
    """Say what a list of names lacks of the nearest choice, and which of its names are nearly right."""
    normal = [_normal(name) for name in names]
    choice = max(choices, key=lambda one: sum(name in normal for name in one))
    missing = [name for name in choice if name not in normal]
    listed = ", ".join(shown(name) for name in names[:_LISTED]) + (", ..." if len(names) > _LISTED else "")
    hints = [hint for name in missing if (hint := _nearly(name, names, choice))]
    return "\n  ".join([f"missing: {', '.join(missing)}; there: {listed}", *hints])


def _nearly(name: str, names: Sequence[str], choice: tuple[str, ...]) -> str | None:
    """Find the name most like one asked for, and say what differs."""
    others = {_normal(one): one for one in names[:_COMPARED] if _normal(one) and _normal(one) not in choice}
    stem, unit = name.rsplit("_", 1)
    for normal, found in others.items():
        if re.fullmatch(rf"{re.escape(stem)}(?:[ \t_]*[\[(]?[ \t_]*[^\W\d_]+\.?[\])]?)?", normal):
            return f"{shown(found)} is not {name}: give values in {unit}, and name the column {name}"
    if near := difflib.get_close_matches(name, others, 1, _ALIKE):
        found = others[near[0]]
        strange = strange_characters(found)
        return f"{shown(found)} is not {name}" + (f": it has {strange}" if strange else "")
    return None


def _no_header(lines: list[str], choices: Choices, file: str) -> Exception:
    wanted = {name for choice in choices for name in choice}
    asked = "name " + " or ".join(", ".join(choice) for choice in choices) + " in one line above the rows"
    candidates = (
        (sum(_normal(name) in wanted for name in names[:_COMPARED]), -index, len(names), names, separator)
        for index, line in enumerate(lines[:_SEARCHED])
        for separator in SEPARATORS
        if (names := header_names(line, separator))
    )
    known, index, _, names, separator = max(candidates, default=(0, 0, 0, [], ","))
    if blank := _separated_by_something_else(lines, choices):
        return refusal(file, f"names and values are separated by {blank[1]}.", f"use commas: {asked}.", blank[0])
    if not known:
        return refusal(file, f"no line names the columns of a measurement{_what_else(lines)}.", f"{asked}.")
    what = f"these columns are not a measurement.\n  {_lacking(names, choices)}"
    if ragged := _first_ragged(lines, -index, len(names), separator):
        what += f"\n  {ragged}"
    return refusal(file, what, f"{asked}.", 1 - index)


def _what_else(lines: list[str]) -> str:
    first, line = next((number, line) for number, line in enumerate(lines, 1) if line.strip())
    for separator in SEPARATORS:
        cells = header_names(line, separator)
        if len(cells) > 1 and all(NUMBER.fullmatch(clean_number(cell)) for cell in cells):
            return f"; line {first} already is a row of numbers"
    return f"; line {first} is {shown(line)}"


def _first_ragged(lines: list[str], index: int, count: int, separator: str) -> str | None:
    for number, line in enumerate(lines[index + 1 : index + 1 + _SEARCHED], index + 2):
        cells = header_names(line, separator)
        if cells and len(cells) != count:
            return f"line {number} has {len(cells)} {'value' if len(cells) == 1 else 'values'}, not {count}"
    return None


def _separated_by_something_else(lines: list[str], choices: Choices) -> tuple[int, str] | None:
    """Find a line that names all columns, separated by blanks or bars: its number, and what separates them."""
    for number, line in enumerate(lines[:_SEARCHED], 1):
        for what, parts in (("bars", line.strip("| ").split("|")), ("blanks", line.split())):
            if _columns([part.lstrip("#%") for part in parts], choices):
                return number, what
    return None
