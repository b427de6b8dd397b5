"""Several runs in numbers: each against the first, and which is best."""

from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.compare.criteria import CRITERIA, Criterion, MeasuredPath, Preference, paced_alike
from pipeline.compare.metrics import markdown, per_cent_of
from pipeline.errors import ArgumentError


@dataclass(frozen=True)
class RunsRow:
    """One figure of several runs, in their order.

    Attributes
    ----------
    figure, unit : str
        What is compared, and its unit (empty if it has none).
    prefers : str
        Whether a lower or a higher value is better, or neither.
    values : tuple of float or None
        One per run; None where it is not known.
    differences, per_cent : tuple of float or None
        Difference of each value from that of the first run, and the same in per cent of it; None where unknown.
    best : tuple of int
        Numbers of the runs with the best value, from 0; empty if all are equal or no value is better.
    """

    figure: str
    unit: str
    prefers: Preference
    values: tuple[float | None, ...]
    differences: tuple[float | None, ...]
    per_cent: tuple[float | None, ...]
    best: tuple[int, ...]


def compare_runs(measured: Sequence[MeasuredPath]) -> list[RunsRow]:
    """Compare runs, at least two, by every criterion that is known for at least two of them.

    Raises
    ------
    ArgumentError
        If there are fewer than two.
    """
    if len(measured) < 2:
        raise ArgumentError(f"measured: expected at least two, not {len(measured)}")
    measured = paced_alike(measured)
    rows = []
    for criterion in CRITERIA:
        values = tuple(criterion.value(one) for one in measured)
        if sum(value is not None for value in values) >= 2:
            rows.append(_row(criterion, values))
    return rows


def _row(criterion: Criterion, values: tuple[float | None, ...]) -> RunsRow:
    first = values[0]
    differences = tuple(None if first is None or value is None else value - first for value in values)
    per_cent = tuple(None if first is None or change is None else per_cent_of(first, change) for change in differences)
    return RunsRow(
        criterion.name, criterion.unit, criterion.prefers, values, differences, per_cent, _best(criterion, values)
    )


def _best(criterion: Criterion, values: tuple[float | None, ...]) -> tuple[int, ...]:
    known = [value for value in values if value is not None]
    if criterion.prefers == "neither" or max(known) - min(known) <= criterion.resolution:
        return ()
    target = min(known) if criterion.prefers == "lower" else max(known)
    return tuple(
        number
        for number, value in enumerate(values)
        if value is not None and abs(value - target) <= criterion.resolution
    )


def runs_header(names: Sequence[str]) -> tuple[str, ...]:
    """Name the columns of `runs_cells`."""
    return ("figure", "unit", *names, "best")


def runs_cells(names: Sequence[str], rows: Sequence[RunsRow]) -> list[tuple[str, ...]]:
    """Format rows as text: five significant digits, with difference and per cent against the first run."""
    return [_cells(names, row) for row in rows]


def _cells(names: Sequence[str], row: RunsRow) -> tuple[str, ...]:
    best = ", ".join(names[number] for number in row.best)
    if not best and row.prefers != "neither":
        best = "equal"
    values = [_value(row, number) for number in range(len(row.values))]
    return (row.figure, row.unit, *values, best)


def _value(row: RunsRow, number: int) -> str:
    value, difference, per_cent = row.values[number], row.differences[number], row.per_cent[number]
    if value is None:
        return "unknown"
    if number == 0 or difference is None:
        return f"{value:.5g}"
    share = "" if per_cent is None or not row.best else f", {per_cent:+.1f} %"
    return f"{value:.5g} ({difference:+.3g}{share})"


def runs_markdown(names: Sequence[str], rows: Sequence[RunsRow]) -> str:
    """Write rows as a Markdown table, numbers right-aligned, ending with a newline."""
    header = runs_header(names)
    return markdown(header, runs_cells(names, rows), words=(0, 1, len(header) - 1))
