"""Markdown that is written by programs."""

import re
from collections.abc import Iterable, Sequence

_CODE_OR_MARKUP = re.compile(r"(`[^`]+`)|([*_<>\[\]{}|`])")
_BAR = re.compile(r"(?<!\\)\|")


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a table; line breaks and bars in cells are made harmless."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(_cell(cell) for cell in line) + " |" for line in lines) + "\n"


def literal(text: object) -> str:
    """Write text as code."""
    return f"`{text}`"


def plain(text: str) -> str:
    """Escape what Markdown would take for markup, except code in backticks."""
    return _CODE_OR_MARKUP.sub(lambda found: found[1] or f"\\{found[2]}", text)


def _cell(text: str) -> str:
    return _BAR.sub(r"\\|", " ".join(text.split()))
