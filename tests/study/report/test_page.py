"""The report of a study: what it says, offline, with everything escaped."""

import base64
import gzip
import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.config import Config
from pipeline.study.cases import Case, Cases
from pipeline.study.report import render_study
from pipeline.study.report.history import history
from pipeline.study.report.pareto import front, undominated
from pipeline.study.rows import Ending, Row
from pipeline.study.table import table_of
from tests.study.fakes import cases_of, done_row


def test_a_study_without_a_result_has_a_page(tmp_path: Path, quick_config: Config) -> None:
    """Also where it says what to weigh."""
    cases = cases_of(tmp_path, quick_config, pareto=["path.kappa_max", "-route.steps"], figures=["path.kappa_max"])
    for ended in ([], [(case, Row(case.key, Ending.NO_SOLUTION, "no route")) for case in cases]):
        text = render_study(cases.study, table_of(cases, ended), 3, lambda run: run).decode()
        assert f"0 of {len(ended)} runs have a result" in text


def page(folder: Path, config: Config, **keys: Any) -> str:
    """Render a study whose second run has no route, for a reason that looks like HTML."""
    cases = cases_of(folder, config, **keys)
    ended = []
    for case in cases:
        failed = Row(case.key, Ending.NO_SOLUTION, "no <b>route", "</script><script>alert(1)</script>")
        ended.append((case, failed if case.number == 2 else done_row(case)))
    return render_study(cases.study, table_of(cases, ended), 4, lambda run: f"{run}/report.html").decode()


def test_it_shows_every_run_and_links_to_it(tmp_path: Path, quick_config: Config) -> None:
    """Counts, pictures for each parameter and the reasons are there."""
    text = page(tmp_path, quick_config)
    assert "2 of 3 runs have a result" in text
    assert "1 have not been run yet" in text
    assert len(re.findall(r'<a href="runs/[0-9a-f]{16}/report.html">', text)) == 3
    headings = re.findall(r"<h2[^>]*>([^<]+)</h2>", text)
    assert headings == [
        "Parallel coordinates",
        "Pareto front",
        "Over task.tilt_max_deg",
        "Runs that do not count, by reason",
        "Runs",
    ]


def test_an_optimisation_shows_the_best_values_run_by_run(tmp_path: Path, quick_config: Config) -> None:
    """Of each objective, over the runs that count: less is better, or more."""
    cases = cases_of(
        tmp_path,
        quick_config,
        design={"kind": "optimise", "samples": 9},
        parameters=[{"key": "task.tilt_max_deg", "min": 5, "max": 30}],
        pareto=["path.kappa_integral", "-trajectory.duration_s"],
        constraints=[{"figure": "path.kappa_integral", "max": 90}],
    )
    made = [tilted(cases, number, tilt) for number, tilt in enumerate((20, 10, 25, 15), 1)]
    ended = [(case, done_row(case)) for case in made]
    table = table_of(cases, ended)
    plot = history(table, cases.study.pareto)
    assert plot is not None
    assert plot.figure["data"][1]["x"] == [1, 3, 4]
    assert plot.figure["data"][1]["y"] == [50.0, 40.0, 40.0]
    assert plot.figure["data"][3]["y"] == [20.0, 25.0, 25.0]
    assert front(table, cases.study.pareto) == [2]
    text = render_study(cases.study, table, 9, lambda run: run).decode()
    assert "Best values, run by run" in text
    assert "path.kappa_integral above 90" in text
    assert history(table_of(cases, []), cases.study.pareto) is None


def tilted(cases: Cases, number: int, tilt_deg: float) -> Case:
    """Make the case of a tilt limit."""
    return cases.case(number, {"task.tilt_max_deg": tilt_deg})


def test_text_is_escaped_and_nothing_is_fetched(tmp_path: Path, quick_config: Config) -> None:
    """Neither reasons nor names become HTML; the page refers to no other file but the runs."""
    text = page(tmp_path, quick_config)
    assert "<b>route" not in text
    assert "<script>alert" not in text
    assert not re.search(r'(?:src|href)="(?!data:|#|runs/)', text.split("<script>")[0])


def test_the_numbers_of_the_pictures_are_those_of_the_table(tmp_path: Path, quick_config: Config) -> None:
    """Both runs that are done are on the Pareto front: the faster one has more kappa."""
    text = page(tmp_path, quick_config)
    found = re.search(r'id="report-data">(.*?)</script>', text)
    assert found is not None
    front = json.loads(gzip.decompress(base64.b64decode(found[1])))[1]["data"][1]
    assert dict(zip(front["x"], front["y"], strict=True)) == {1000.0 / 30.0: 30.0, 100.0: 10.0}


def test_a_point_is_on_the_front_unless_another_beats_it() -> None:
    """Equal points do not beat each other."""
    costs = np.array([[1.0, 3.0], [2.0, 2.0], [2.0, 3.0], [3.0, 1.0], [1.0, 3.0]])
    assert undominated(costs) == [True, True, False, True, True]
