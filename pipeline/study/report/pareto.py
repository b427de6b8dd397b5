"""The runs of a study that no other run beats in every objective."""

from collections.abc import Sequence

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.study.table import Table, figure_column

_USUAL = ("path.kappa_integral", "trajectory.duration_s", "route.objective", "route.kappa_max")
"""What is weighed where a study does not say, the first two that runs have: nearness to singularities and time."""


def objectives(wanted: Sequence[str], table: Table) -> tuple[str, ...]:
    """Name the columns of the objectives: those a study says, or the usual ones; of `-name` more is better."""
    if wanted:
        signed = [(name[: name.startswith("-")], name.removeprefix("-")) for name in wanted]
        named = [(sign, figure_column(name, table.parameters), name) for sign, name in signed]
        # A parameter may be weighed, too.
        found = [f"{sign}{column if column in table.columns else name}" for sign, column, name in named]
        return tuple(name for name in found if name.removeprefix("-") in table.columns)
    usual = [figure_column(name, table.parameters) for name in _USUAL]
    return numeric(table, tuple(name for name in usual if name in table.figures))[:2]


def numeric(table: Table, names: Sequence[str]) -> tuple[str, ...]:
    """Keep the names of columns that have numbers."""
    return tuple(name for name in names if any(_is_number(value) for value in table.columns.get(name, ())))


def front(table: Table, names: Sequence[str]) -> list[int]:
    """List the rows that count and that no other row beats in one objective without losing in another."""
    signs = np.array([-1.0 if name.startswith("-") else 1.0 for name in names])
    columns = [table.columns[name.removeprefix("-")] for name in names]
    done = [
        index
        for index, reason in enumerate(table.columns["reason"])
        if reason is None and all(_is_number(column[index]) for column in columns)
    ]
    if not done or not names:
        return []
    costs = signs * np.array([[column[index] for column in columns] for index in done], dtype=float)
    return [index for index, best in zip(done, undominated(costs), strict=True) if best]


def undominated(costs: FloatArray) -> list[bool]:
    """Mark the rows (n, m) that no other row is at most equal to everywhere, and below somewhere."""
    marks = []
    for row in costs:
        no_worse, better = (costs <= row).all(axis=1), (costs < row).any(axis=1)
        marks.append(not bool((no_worse & better).any()))
    return marks


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
