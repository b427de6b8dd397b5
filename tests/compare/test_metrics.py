"""The comparison of coarse and refined path as rows and as a table."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.compare.criteria import MeasuredPath
from pipeline.compare.metrics import TABLE_HEADER, ComparisonRow, compare_paths, markdown_table, table_cells
from pipeline.compare.motion import MotionFigures
from pipeline.refine.measure import PathFigures, PathSamples, measure_path
from pipeline.retime import MotionQuality

COARSE_PATH = PathFigures(
    kappa_max=40.0,
    kappa_max_s=0.4,
    kappa_integral=500.0,
    length=20.0,
    closure_residual_m=1e-13,
    measures={"min_link_distance_m": 0.040, "min_rail_distance_m": 0.5, "max_tilt_deg": 30.0},
    det_sign_constant=True,
    modes=("LLL", "RLL"),
    actuator_length_m=4.0,
    actuator_distance_m=2.0,
)
REFINED_PATH = dataclasses.replace(
    COARSE_PATH,
    kappa_max=30.0,
    kappa_max_s=0.5,
    kappa_integral=350.0,
    length=21.0,
    closure_residual_m=3e-13,
    measures={"min_link_distance_m": 0.030, "min_rail_distance_m": 0.6, "max_tilt_deg": 27.0},
    actuator_length_m=3.0,
)
COARSE, REFINED = MeasuredPath(COARSE_PATH), MeasuredPath(REFINED_PATH)
SLOW, FAST = MotionFigures(8.0, 2.0, 0.5, 40.0, 10.0), MotionFigures(4.0, 2.0, 0.4, 40.0, 10.0)

positive = st.floats(1e-3, 1e3)
figures = st.builds(
    PathFigures,
    kappa_max=positive,
    kappa_max_s=st.floats(0.0, 1.0),
    kappa_integral=positive,
    length=positive,
    closure_residual_m=st.floats(0.0, 1e-6),
    measures=st.fixed_dictionaries(
        {"min_link_distance_m": positive, "min_rail_distance_m": positive, "max_tilt_deg": st.floats(0.0, 85.0)}
    ),
    det_sign_constant=st.just(True),
    modes=st.sampled_from([("LLL",), ("LLL", "RLL"), ("LLL", "LRR", "RRR")]),
    actuator_length_m=positive,
    actuator_distance_m=positive,
).map(MeasuredPath)


def by_name(rows: list[ComparisonRow]) -> dict[str, ComparisonRow]:
    """Index rows by their figure."""
    return {row.figure: row for row in rows}


def test_lower_kappa_is_better_and_counts_negative() -> None:
    """350 instead of 500 is -150, -30 %, and better."""
    row = by_name(compare_paths(COARSE, REFINED))["kappa integral"]
    assert (row.coarse, row.refined, row.difference) == (500.0, 350.0, -150.0)
    assert row.per_cent == pytest.approx(-30.0)
    assert (row.prefers, row.better, row.unit) == ("lower", "refined", "steps")


@pytest.mark.parametrize(
    ("figure", "per_cent", "better"),
    [
        ("largest kappa", -25.0, "refined"),
        ("largest kappa at s", 25.0, "neither"),
        ("length", 5.0, "coarse"),
        ("least link-link distance", -25.0, "coarse"),
        ("least link-rail distance", 20.0, "refined"),
        ("largest tilt", -10.0, "refined"),
        ("closure residual", 200.0, "equal"),
        ("length in actuator space", -25.0, "refined"),
        ("length against straight line", -25.0, "refined"),
    ],
)
def test_every_figure_knows_its_better_direction(figure: str, per_cent: float, better: str) -> None:
    """Distances are better when larger, all else when smaller; rounding in the closure does not count."""
    row = by_name(compare_paths(COARSE, REFINED))[figure]
    assert row.per_cent == pytest.approx(per_cent)
    assert row.better == better


def test_no_per_cent_of_zero() -> None:
    """A coarse value of zero has no percentage, and its cell is empty."""
    rows = compare_paths(
        MeasuredPath(dataclasses.replace(COARSE_PATH, measures={**COARSE_PATH.measures, "max_tilt_deg": 0.0})), REFINED
    )
    row = by_name(rows)["largest tilt"]
    assert row.per_cent is None
    assert row.better == "coarse"
    assert table_cells([row])[0][5] == ""


def with_motions(coarse: MotionFigures, refined: MotionFigures) -> list[ComparisonRow]:
    """Compare both paths in time, too."""
    return compare_paths(dataclasses.replace(COARSE, motion=coarse), dataclasses.replace(REFINED, motion=refined))


def test_durations_are_optional() -> None:
    """Rows about time appear exactly when both motions are known."""
    assert "duration" not in by_name(compare_paths(COARSE, REFINED))
    assert "duration" not in by_name(compare_paths(dataclasses.replace(COARSE, motion=SLOW), REFINED))
    row = by_name(with_motions(SLOW, FAST))["duration"]
    assert (row.difference, row.per_cent, row.better, row.unit) == (-4.0, -50.0, "refined", "s")


def test_reversals_and_the_least_time_are_compared() -> None:
    """Fewer sign changes are better, all actuators together; durations are compared with the same least time."""
    rough = MotionQuality((1, 0, 0, 0, 2), (4, 4, 4, 4, 4), 8.0, (2.0, 1.0, 1.0, 1.0, 1.0))
    smooth = MotionQuality((1, 0, 0, 0, 0), (1, 1, 1, 1, 1), 4.0, rough.least_times_s)
    motions = (dataclasses.replace(SLOW, quality=rough), dataclasses.replace(FAST, quality=smooth))
    rows = by_name(with_motions(*motions))
    for figure, coarse, refined in (
        ("duration against least time", 4.0, 2.0),
        ("sign changes of velocity", 3, 1),
        ("sign changes of acceleration", 20, 5),
    ):
        assert (rows[figure].coarse, rows[figure].refined, rows[figure].better) == (coarse, refined, "refined")


def test_peaks_as_driven_and_equally_long() -> None:
    """At the same limits peaks are equal; given the slower one's time, the faster one needs a quarter, an eighth."""
    rows = by_name(with_motions(SLOW, FAST))
    assert rows["peak cart acceleration"].better == "equal"
    assert rows["peak telescope acceleration"].better == "refined"
    assert rows["equally long: cart acceleration"].per_cent == -75.0
    assert rows["equally long: cart jerk"].per_cent == -87.5
    assert rows["equally long: cart jerk"].coarse == 40.0


def test_no_row_for_jerk_without_bound() -> None:
    """Where accelerations jump there is no peak of jerk to compare."""
    jumping = dataclasses.replace(FAST, cart_jerk_mps3=np.inf, telescope_jerk_mps3=np.inf)
    assert not any("jerk" in name for name in by_name(with_motions(SLOW, jumping)))


@given(a=figures, b=figures)
def test_swapping_the_paths_swaps_the_verdicts(a: MeasuredPath, b: MeasuredPath) -> None:
    """Differences change sign and better becomes the other one, whatever the values."""
    other = {"coarse": "refined", "refined": "coarse", "equal": "equal", "neither": "neither"}
    for there, back in zip(compare_paths(a, b), compare_paths(b, a), strict=True):
        assert there.difference == -back.difference
        assert there.better == other[back.better]


@given(a=figures)
def test_a_path_equals_itself(a: MeasuredPath) -> None:
    """No figure of a path is better than its own."""
    assert {row.better for row in compare_paths(a, a)} == {"equal", "neither"}


def test_measured_paths_compare(coarse: PathSamples, refined: PathSamples) -> None:
    """The swaying path is longer than the straight one and collects more kappa."""
    steps = np.array([0.1, 0.06, 0.06, 0.1, 0.1])
    rows = by_name(compare_paths(*(MeasuredPath(measure_path(path, steps)) for path in (coarse, refined))))
    assert rows["length"].better == "refined"
    assert rows["kappa integral"].better == "refined"
    assert (rows["working-mode changes"].coarse, rows["working-mode changes"].better) == (0.0, "neither")


def test_markdown_is_a_table() -> None:
    """Every line has as many cells as the header; the second is the rule, numbers to the right."""
    lines = markdown_table(compare_paths(COARSE, REFINED)).splitlines()
    assert len(lines) == 2 + 11
    assert {line.count("|") for line in lines} == {len(TABLE_HEADER) + 1}
    assert lines[1] == "| :-- | :-- | --: | --: | --: | --: | :-- |"
    assert lines[2] == "| kappa integral | steps | 500 | 350 | -150 | -30.0 | refined |"
    assert lines[4] == "| largest kappa at s |  | 0.4 | 0.5 | +0.1 |  |  |"
    assert lines[11] == "| closure residual | m | 1e-13 | 3e-13 | +2e-13 |  | equal |"
    assert lines[12] == "| working-mode changes |  | 1 | 1 | +0 |  |  |"


def test_cells_fill_the_header() -> None:
    """Rows for any other kind of table have one text per heading."""
    for cells in table_cells(with_motions(SLOW, FAST)):
        assert len(cells) == len(TABLE_HEADER)
        assert all(isinstance(cell, str) for cell in cells)
