"""The refined path against the coarse one, in numbers: rows for a table, a report or a test."""

from dataclasses import dataclass
from typing import Literal

from pipeline.refine.measure import PathFigures

Preference = Literal["lower", "higher", "neither"]
Better = Literal["coarse", "refined", "equal", "neither"]

TABLE_HEADER = ("figure", "unit", "coarse", "refined", "difference", "%", "better")
"""Headings of `table_cells`."""


@dataclass(frozen=True)
class _Figure:
    """A figure to compare: its attribute in `PathFigures`, and the difference below which it is equal."""

    attribute: str
    name: str
    unit: str
    prefers: Preference
    resolution: float


# Differences below the resolution are what sampling and rounding make, not what the paths are.
_FIGURES = (
    _Figure("kappa_integral", "kappa integral", "steps", "lower", 1e-6),
    _Figure("kappa_max", "largest kappa", "", "lower", 1e-6),
    _Figure("kappa_max_s", "largest kappa at s", "", "neither", 1e-6),
    _Figure("length", "length", "steps", "lower", 1e-6),
    _Figure("min_link_distance_m", "least link-link distance", "m", "higher", 1e-6),
    _Figure("min_rail_distance_m", "least link-rail distance", "m", "higher", 1e-6),
    _Figure("max_tilt_deg", "largest tilt", "deg", "lower", 1e-4),
    _Figure("closure_residual_m", "closure residual", "m", "lower", 1e-9),
)
_DURATION = _Figure("duration_s", "duration", "s", "lower", 1e-6)


@dataclass(frozen=True)
class ComparisonRow:
    """One figure of both paths.

    Attributes
    ----------
    figure, unit : str
        What is compared and its unit, empty where it has none; a step is the unit of the route's metric.
    coarse, refined : float
        The two values.
    difference : float
        refined - coarse.
    per_cent : float or None
        The difference in per cent of the coarse value; None where that is zero.
    prefers : str
        Whether a lower or a higher value is better, or neither.
    better : str
        The better path; equal below the figure's resolution, neither where there is no better.
    """

    figure: str
    unit: str
    coarse: float
    refined: float
    difference: float
    per_cent: float | None
    prefers: Preference
    better: Better


def comparison_rows(
    coarse: PathFigures, refined: PathFigures, durations_s: tuple[float, float] | None = None
) -> list[ComparisonRow]:
    """Compare two paths figure by figure; `durations_s` (coarse, refined) adds a row for their durations."""
    rows = [_row(figure, getattr(coarse, figure.attribute), getattr(refined, figure.attribute)) for figure in _FIGURES]
    if durations_s is not None:
        rows.append(_row(_DURATION, *durations_s))
    return rows


def _row(figure: _Figure, coarse: float, refined: float) -> ComparisonRow:
    difference = refined - coarse
    return ComparisonRow(
        figure=figure.name,
        unit=figure.unit,
        coarse=coarse,
        refined=refined,
        difference=difference,
        per_cent=100.0 * difference / abs(coarse) if coarse != 0.0 else None,
        prefers=figure.prefers,
        better=_better(figure, difference),
    )


def _better(figure: _Figure, difference: float) -> Better:
    if figure.prefers == "neither":
        return "neither"
    if abs(difference) <= figure.resolution:
        return "equal"
    return "refined" if (difference < 0.0) == (figure.prefers == "lower") else "coarse"


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
    rule = [":--", ":--", "--:", "--:", "--:", "--:", ":--"]
    lines = [TABLE_HEADER, tuple(rule), *table_cells(rows)]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)
