"""Markdown that is written by programs."""

from collections.abc import Iterable, Sequence


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a table; line breaks and bars in cells are made harmless."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(_cell(cell) for cell in line) + " |" for line in lines) + "\n"


def literal(text: object) -> str:
    """Write text as code."""
    return f"`{text}`"


def plain(text: str) -> str:
    """Escape what Markdown would take for markup."""
    return text.translate({ord(sign): f"\\{sign}" for sign in "*_<>[]{}|`"})


def _cell(text: str) -> str:
    return " ".join(text.split())
