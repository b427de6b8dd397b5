"""The table of a study: a row per run, with parameters, ending, figures, time and versions."""

import csv
import difflib
import io
import json
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pipeline.artifacts import write_whole
from pipeline.study.cases import Case, Cases
from pipeline.study.config import StudyConfig
from pipeline.study.design import varied_paths
from pipeline.study.engine import RUNS
from pipeline.study.extra import library
from pipeline.study.optimise.trials import ended_cases
from pipeline.study.rows import Row
from pipeline.study.store import Store
from pipeline.study.verdict import shortfall

PARQUET, CSV = "study.parquet", "study.csv"
_RESULT = "result."
_OF_THE_RUN = ("number", "status", "reason", "message", "seconds", "seed", "version", "run")


@dataclass(frozen=True)
class Table:
    """A table by columns, of runs in the order of the design.

    Attributes
    ----------
    parameters, figures : tuple of str
        The names of columns that are parameters, and figures.
    columns : dict
        The values of every column; None where a run has none.
    """

    parameters: tuple[str, ...]
    figures: tuple[str, ...]
    columns: dict[str, list[Any]]

    def __len__(self) -> int:
        return len(self.columns["number"])

    def rows(self) -> Iterable[dict[str, Any]]:
        """Give the rows, each by the names of the columns."""
        for values in zip(*self.columns.values(), strict=True):
            yield dict(zip(self.columns, values, strict=True))


def figure_column(figure: str, parameters: Collection[str]) -> str:
    """Name the column of a figure: its path, after `result.` where a parameter or another column has that name."""
    return f"{_RESULT}{figure}" if figure in parameters or figure in _OF_THE_RUN else figure


def build_table(cases: Cases, store: Store) -> Table:
    """Collect the rows of all runs of a design that have ended."""
    return table_of(cases, ended_cases(cases, store))


def table_of(cases: Cases, rows: Iterable[tuple[Case, Row]]) -> Table:
    """Put cases and their rows into columns."""
    # Of a million cases not all configurations, nor all figures, are held at a time.
    wanted = cases.study.kept_figures
    ended = [(_slim_case(case), _slim_row(row, wanted) if wanted else row) for case, row in rows]
    parameters = varied_paths(cases.study)
    figures = {figure_column(path, parameters): path for path in wanted or _numbers(row for _, row in ended)}
    columns = {
        "number": [case.number for case, _ in ended],
        **{path: _tidy([case.point.get(path) for case, _ in ended]) for path in parameters},
        "status": [row.ending for _, row in ended],
        "reason": [shortfall(cases.study, row) or None for _, row in ended],
        **{name: _tidy([row.figures.get(path) for _, row in ended]) for name, path in figures.items()},
        "message": [row.message or None for _, row in ended],
        "seconds": [row.seconds for _, row in ended],
        "seed": [cases.study.design.seed for _ in ended],
        "version": [row.program for _, row in ended],
        "run": [f"{RUNS}/{case.folder}" for case, _ in ended],
    }
    return Table(parameters, tuple(figures), columns)


def _slim_case(case: Case) -> Case:
    return replace(case, data={})


def _slim_row(row: Row, wanted: Sequence[str]) -> Row:
    return replace(row, figures={name: row.figures.get(name) for name in wanted})


def unknown_figures(study: StudyConfig, table: Table, store: Store) -> list[str]:
    """Say which figures were asked for that no run has, and which it has that are near."""
    missing = [
        name
        for name in study.kept_figures
        if len(table) and all(value is None for value in table.columns[figure_column(name, table.parameters)])
    ]
    known = sorted({name for row in store.rows() for name in row.figures}) if missing else []
    said = []
    for name in missing:
        near = difflib.get_close_matches(name, known, n=3)
        said.append(f"no run has the figure {name}" + (f"; near it are {', '.join(near)}" if near else ""))
    return said


def write_table(folder: Path, table: Table) -> None:
    """Write the table as Parquet and as CSV, each whole or not at all.

    Raises
    ------
    UsageError
        When the library for Parquet is not installed.
    """
    write_whole(folder / PARQUET, _parquet(table))
    write_whole(folder / CSV, _csv(table))


def _numbers(rows: Iterable[Row]) -> tuple[str, ...]:
    """Name all figures that are numbers, but for entries of lists."""
    return tuple(
        dict.fromkeys(
            path
            for row in rows
            for path, value in row.figures.items()
            if isinstance(value, int | float) and not isinstance(value, bool) and "[" not in path
        )
    )


def _tidy(values: list[Any]) -> list[Any]:
    """Give all values of a column one type: numbers, truth values, or text; lists and sections become JSON."""
    plain = [json.dumps(value) if isinstance(value, list | dict) else value for value in values]
    given = [value for value in plain if value is not None]
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in given):
        whole = all(isinstance(value, int) for value in given)
        return [value if value is None or whole else float(value) for value in plain]
    if all(isinstance(value, bool) for value in given):
        return plain
    return [value if value is None or isinstance(value, str) else json.dumps(value) for value in plain]


def _parquet(table: Table) -> bytes:
    library("pyarrow")
    parquet, arrow = library("pyarrow.parquet"), library("pyarrow")
    buffer = io.BytesIO()
    # A column without any value is one of numbers that are missing.
    arrays = {
        name: arrow.array(values, type=arrow.float64() if all(one is None for one in values) else None)
        for name, values in table.columns.items()
    }
    parquet.write_table(arrow.table(arrays), buffer)
    return buffer.getvalue()


def _csv(table: Table) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table.columns)
    writer.writerows(zip(*table.columns.values(), strict=True))
    return text.getvalue().encode()
