"""The refined path against the coarse one in numbers: rows for a table, a report or a test."""

from dataclasses import dataclass
from typing import Literal

from pipeline.compare.criteria import CRITERIA, Criterion, MeasuredPath, Preference, paced_alike

Better = Literal["coarse", "refined", "equal", "neither"]

TABLE_HEADER = ("figure", "unit", "coarse", "refined", "difference", "%", "better")
"""Headings of `table_cells`."""


@dataclass(frozen=True)
class ComparisonRow:
    """One figure of both paths.

    Attributes
    ----------
    figure, unit : str
        What is compared, and its unit (empty if it has none); a step is the unit of the route's metric.
    coarse, refined : float
        The two values.
    difference : float
        refined - coarse.
    per_cent : float or None
        The difference in per cent of the coarse value; None where that is zero.
    prefers : str
        Whether a lower or a higher value is better, or neither.
    better : str
        The better path; equal up to the resolution of the figure, neither where no value is better.
    """

    figure: str
    unit: str
    coarse: float
    refined: float
    difference: float
    per_cent: float | None
    prefers: Preference
    better: Better


def compare_paths(coarse: MeasuredPath, refined: MeasuredPath) -> list[ComparisonRow]:
    """Compare two paths by every criterion that is known for both."""
    coarse, refined = paced_alike([coarse, refined])
    rows = []
    for criterion in CRITERIA:
        before, after = criterion.value(coarse), criterion.value(refined)
        if before is not None and after is not None:
            rows.append(_row(criterion, before, after))
    return rows


def _row(criterion: Criterion, coarse: float, refined: float) -> ComparisonRow:
    difference = refined - coarse
    return ComparisonRow(
        figure=criterion.name,
        unit=criterion.unit,
        coarse=coarse,
        refined=refined,
        difference=difference,
        per_cent=per_cent_of(coarse, difference),
        prefers=criterion.prefers,
        better=_better(criterion, difference),
    )


def per_cent_of(value: float, difference: float) -> float | None:
    """Express a difference in per cent of a value; None where that is zero."""
    return 100.0 * difference / abs(value) if value != 0.0 else None


def _better(criterion: Criterion, difference: float) -> Better:
    if criterion.prefers == "neither":
        return "neither"
    if abs(difference) <= criterion.resolution:
        return "equal"
    return "refined" if (difference < 0.0) == (criterion.prefers == "lower") else "coarse"


def table_cells(rows: list[ComparisonRow]) -> list[tuple[str, ...]]:
    """Format rows as text under `TABLE_HEADER`: five significant digits, per cent with one decimal."""
    return [_cells(row) for row in rows]


def _cells(row: ComparisonRow) -> tuple[str, ...]:
    per_cent = "" if row.per_cent is None or row.better in ("equal", "neither") else f"{row.per_cent:+.1f}"
    better = "" if row.better == "neither" else row.better
    return (
        row.figure,
        row.unit,
        f"{row.coarse:.5g}",
        f"{row.refined:.5g}",
        f"{row.difference:+.3g}",
        per_cent,
        better,
    )


def markdown_table(rows: list[ComparisonRow]) -> str:
    """Write rows as a Markdown table, numbers right-aligned, ending with a newline."""
    return markdown(TABLE_HEADER, table_cells(rows), words=(0, 1, 6))


def markdown(header: tuple[str, ...], cells: list[tuple[str, ...]], words: tuple[int, ...]) -> str:
    """Write a Markdown table with the columns `words` aligned left, all others right."""
    rule = tuple(":--" if column in words else "--:" for column in range(len(header)))
    return "".join("| " + " | ".join(line) + " |\n" for line in (header, rule, *cells))
