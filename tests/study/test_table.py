"""The table of a study: one row per run that has ended, in the order of the design."""

import csv
import io
from pathlib import Path

import pyarrow.parquet as parquet
import pytest

from pipeline.config import Config
from pipeline.study.report.pareto import objectives
from pipeline.study.report.plots import shown_figures
from pipeline.study.rows import Ending, Row
from pipeline.study.store import Store
from pipeline.study.table import CSV, PARQUET, Table, build_table, table_of, unknown_figures, write_table
from tests.study.fakes import cases_of, done_row


@pytest.fixture
def table(tmp_path: Path, quick_config: Config) -> Table:
    """Tabulate a study whose second run has no route."""
    cases = cases_of(tmp_path, quick_config)
    ended = []
    for case in cases:
        failed = Row(case.key, Ending.NO_SOLUTION, "no route", "none", {"route.steps": 3})
        ended.append((case, failed if case.number == 2 else done_row(case)))
    return table_of(cases, ended)


def test_both_files_have_the_same_rows(tmp_path: Path, table: Table) -> None:
    """Numbers stay numbers in Parquet; what is missing is missing."""
    write_table(tmp_path, table)
    read = parquet.read_table(tmp_path / PARQUET).to_pylist()
    assert read == list(table.rows())
    texts = list(csv.DictReader(io.StringIO((tmp_path / CSV).read_text())))
    assert [text["status"] for text in texts] == [row["status"] for row in read] == ["done", "no solution", "done"]
    assert [text["trajectory.duration_s"] for text in texts] == ["10.0", "", "30.0"]
    assert read[1]["trajectory.duration_s"] is None
    assert list(read[0])[:4] == ["number", "task.tilt_max_deg", "status", "reason"]


def test_a_figure_and_a_parameter_of_one_name_are_two_columns(tmp_path: Path, quick_config: Config) -> None:
    """What was asked for stays under its name; what came of it is after `result.`, in the report, too."""
    varied = {"key": "route.kappa_max", "values": [40, 50]}
    cases = cases_of(tmp_path, quick_config, parameters=[varied], pareto=["-route.kappa_max", "path.kappa_max"])
    figures = {"route.kappa_max": 33.0, "path.kappa_max": 30.0}
    table = table_of(cases, [(case, Row(case.key, Ending.DONE, figures=figures)) for case in cases])
    assert table.columns["route.kappa_max"] == [40.0, 50.0]
    assert table.columns["result.route.kappa_max"] == [33.0, 33.0]
    assert (table.parameters, table.figures) == (
        ("route.kappa_max",),
        ("result.route.kappa_max", "path.kappa_max"),
    )
    weighed = objectives(cases.study.pareto, table)
    assert weighed == ("-result.route.kappa_max", "path.kappa_max")
    assert shown_figures(table, ["route.kappa_max"], weighed[1:]) == ("path.kappa_max", "result.route.kappa_max")


def test_pandas_reads_it_in_one_line(tmp_path: Path, table: Table) -> None:
    """As the README says."""
    pandas = pytest.importorskip("pandas")
    write_table(tmp_path, table)
    frame = pandas.read_parquet(tmp_path / PARQUET)
    assert frame.groupby("status")["trajectory.duration_s"].mean()["done"] == 20.0


def test_a_study_that_is_not_finished_has_the_rows_it_has(tmp_path: Path, quick_config: Config) -> None:
    """A figure that no run has is said, with those that are near."""
    cases = cases_of(tmp_path, quick_config, figures=["path.kapa_integral"])
    first = next(iter(cases))
    with Store(tmp_path) as store:
        assert len(build_table(cases, store)) == 0
        store.add(done_row(first))
        table = build_table(cases, store)
        (said,) = unknown_figures(cases.study, table, store)
    assert len(table) == 1
    assert "no run has the figure path.kapa_integral; near it are path.kappa_integral" in said
