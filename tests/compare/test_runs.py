"""Several runs beside each other."""

import dataclasses

import pytest

from pipeline.compare.criteria import MeasuredPath
from pipeline.compare.metrics import compare_paths
from pipeline.compare.motion import MotionFigures
from pipeline.compare.runs import RunsRow, compare_runs, runs_cells, runs_header, runs_markdown
from tests.compare.test_metrics import COARSE, FAST, REFINED, SLOW

NAMES = ("one", "two", "three")
THREE = (COARSE, REFINED, dataclasses.replace(COARSE, path=dataclasses.replace(COARSE.path, length=19.0)))


def by_name(rows: list[RunsRow]) -> dict[str, RunsRow]:
    """Index rows by their figure."""
    return {row.figure: row for row in rows}


def test_differences_are_against_the_first_run() -> None:
    """Sign and per cent count from the first run, whose own difference is zero."""
    row = by_name(compare_runs(THREE))["length"]
    assert row.values == (20.0, 21.0, 19.0)
    assert row.differences == (0.0, 1.0, -1.0)
    assert row.per_cent == pytest.approx((0.0, 5.0, -5.0))
    assert row.best == (2,)


def test_the_best_may_be_several_or_none() -> None:
    """Runs within the resolution of the best are as good; where all are, or nothing is better, none is named."""
    rows = by_name(compare_runs(THREE))
    assert rows["least link-link distance"].best == (0, 2)
    assert rows["closure residual"].best == ()
    assert rows["largest kappa at s"].best == ()


def test_two_runs_are_told_as_two_paths_are() -> None:
    """Values, differences and per cent of two runs are those of the comparison of two paths."""
    a, b = dataclasses.replace(COARSE, motion=SLOW), dataclasses.replace(REFINED, motion=FAST)
    for runs, paths in zip(compare_runs([a, b]), compare_paths(a, b), strict=True):
        assert (runs.figure, runs.values) == (paths.figure, (paths.coarse, paths.refined))
        assert (runs.differences[1], runs.per_cent[1]) == (paths.difference, paths.per_cent)
        assert runs.best == {"coarse": (0,), "refined": (1,)}.get(paths.better, ())


def test_what_is_not_known_of_all_is_left_open() -> None:
    """A run without a motion has unknown durations, and the others are compared all the same."""
    rows = by_name(compare_runs([dataclasses.replace(COARSE, motion=SLOW), REFINED, timed(FAST)]))
    row = rows["duration"]
    assert row.values == (8.0, None, 4.0)
    assert row.differences == (0.0, None, -4.0)
    assert runs_cells(NAMES, [row]) == [("duration", "s", "8", "unknown", "4 (-4, -50.0 %)", "three")]
    assert "equally long: cart jerk" not in rows


def timed(motion: MotionFigures) -> MeasuredPath:
    """Give the refined path a motion."""
    return dataclasses.replace(REFINED, motion=motion)


def test_markdown_is_a_table() -> None:
    """Every line has as many cells as the header; numbers to the right."""
    lines = runs_markdown(NAMES, compare_runs(THREE)).splitlines()
    assert lines[0] == "| figure | unit | one | two | three | best |"
    assert lines[1] == "| :-- | :-- | --: | --: | --: | :-- |"
    assert lines[2] == "| kappa integral | steps | 500 | 350 (-150, -30.0 %) | 500 (+0, +0.0 %) | two |"
    assert {line.count("|") for line in lines} == {len(runs_header(NAMES)) + 1}
