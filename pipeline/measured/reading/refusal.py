"""Refusals of a file: what is wrong, in which line and column, and what to do; invisible characters are shown."""

import re
import unicodedata
from dataclasses import dataclass, field

from pipeline.errors import UsageError

INVISIBLE = re.compile("[\u00ad\u034f\u061c\u115f\u1160\u180e\u200b-\u200f\u202a-\u202e\u2060-\u206f\ufeff]")
"""Characters without width: left by editors, web pages and byte order marks in the middle of a file."""
_LONGEST = 40
_MOST_PROBLEMS = 1000


def refusal(file: str, what: str, advice: str, line: int | None = None, column: str | None = None) -> UsageError:
    """Make the error for something wrong with a file, at a line counted from 1 and a column by its name."""
    place = [file]
    if line is not None:
        place.append(f"line {line}")
    if column is not None:
        place.append(f"column {column}")
    return UsageError(f"{', '.join(place)}: {what}\n  What to change: {advice}")


def shown(text: str) -> str:
    """Quote a text for a message: short, and with escapes for what cannot be seen."""
    quoted = repr(text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}...")
    return INVISIBLE.sub(lambda match: match.group().encode("unicode_escape").decode(), quoted)


def strange_characters(text: str) -> str:
    """Name the characters of a text that are not ASCII, or that cannot be seen: U+0445 CYRILLIC SMALL LETTER HA, ..."""
    strange = dict.fromkeys(char for char in text if not (char.isascii() and char.isprintable()))
    return ", ".join(f"U+{ord(char):04X} {unicodedata.name(char, 'control character')}" for char in strange)


@dataclass
class Problems:
    """The first thing that is wrong with a file, and how many lines have something wrong."""

    file: str
    first: UsageError | None = None
    lines: set[int] = field(default_factory=set)

    def add(self, line: int, what: str, advice: str, column: str | None = None) -> None:
        """Take note of what is wrong in a line, and what to do; the column by its name. Raises when it is too much."""
        self.first = self.first or refusal(self.file, what, advice, line, column)
        self.lines.add(line)
        if len(self.lines) > _MOST_PROBLEMS:
            self.settle()

    def settle(self) -> None:
        """Raise the first problem, if there is one."""
        if self.first is None:
            return
        more = len(self.lines) - 1
        if more:
            least = "At least " if more == _MOST_PROBLEMS else ""
            raise UsageError(
                f"{self.first}\n  {least}{more:,} more {'line' if more == 1 else 'lines'} cannot be read either."
            )
        raise self.first
