"""The atlas as matrices, and what is known of a pair."""

import numpy as np
import pytest

from pipeline.atlas.matrix import matrices
from pipeline.atlas.record import AtlasRecord, MotionRecord, PairRecord, StationRecord
from pipeline.config.choices import RouteObjective
from pipeline.config.task import PoseConfig
from pipeline.errors import UsageError


def pair(origin: str, target: str, status: str = "optimal", **facts: object) -> PairRecord:
    """Make a record."""
    values = {"objective": 10.0, "gap": 0.0, "steps": 4, "kappa_max": 20.0} if status == "optimal" else {}
    limits = {"time_limit_s": 300.0, "memory_gb": 4.0, "fingerprint": "f"}
    return PairRecord(origin=origin, target=target, status=status, **(values | limits | facts))


def atlas(*pairs: PairRecord, names: str = "abc", objective: str = "sum") -> AtlasRecord:
    """Make an atlas."""
    pose = PoseConfig(x_m=1.0, y_m=0.3, z_m=0.9, mode="LLL")
    return AtlasRecord(
        name="cell",
        config_sha256="",
        versions={},
        objective_kind=RouteObjective(objective),
        reversible=True,
        stations=tuple(StationRecord(name=name, pose=pose) for name in names),
        pairs=pairs,
    )


def test_a_matrix_has_figures_and_reasons() -> None:
    """What is neither known nor refused was not searched yet."""
    [matrix] = matrices(
        atlas(
            pair("a", "b"),
            pair("a", "c", "infeasible", reason="none"),
            pair("b", "a", "time limit"),
            pair("b", "c", "impossible"),
            pair("c", "a", "not proven optimal", objective=12.0),
        )
    )
    assert matrix.title == "route: sum of kappa"
    assert matrix.texts == [["", "10.0", "no route"], ["time limit", "", "impossible"], ["12.0 ?", "not yet", ""]]
    np.testing.assert_array_equal(np.isfinite(matrix.values).nonzero(), ([0, 2], [1, 0]))


def test_motions_add_matrices() -> None:
    """One for each figure that some motion has; a pair without one says why."""
    done = MotionRecord(
        status="done", run="runs/a--b", to="retime", kappa_integral=9.0, kappa_bound=30.0, duration_s=6.25
    )
    failed = MotionRecord(status="failed", run="runs/b--a", to="refine", reason="not converged")
    found = matrices(atlas(pair("a", "b", motion=done), pair("b", "a", motion=failed), names="ab", objective="time"))
    assert [matrix.title for matrix in found] == [
        "route: time of the moves (s)",
        "path: kappa integral",
        "path: largest kappa, proven",
        "motion: duration (s)",
    ]
    assert [matrix.texts[0][1] for matrix in found] == ["10.000", "9.0", "30.00", "6.25"]
    assert [matrix.texts[1][0] for matrix in found] == ["10.000", "refine failed", "refine failed", "refine failed"]


@pytest.mark.parametrize(
    ("status", "motion", "to", "is_open"),
    [
        ("optimal", None, "retime", False),
        ("infeasible", None, "retime", False),
        ("impossible", None, "route", False),
        ("time limit", None, "route", True),
        ("failed", None, "route", True),
        ("not proven optimal", None, "route", True),
        ("optimal", MotionRecord(status="done", run="r"), "retime", False),
        ("optimal", MotionRecord(status="failed", run="r"), "retime", True),
        ("optimal", MotionRecord(status="failed", run="r"), "route", False),
    ],
)
def test_what_is_open(status: str, motion: MotionRecord | None, to: str, is_open: bool) -> None:
    """A pair is open while something that was asked for is missing without a proof."""
    record = atlas(pair("a", "b", status, motion=motion)).model_copy(update={"to": to})
    assert bool(record.problems()) == is_open


def test_a_pair_is_found_by_its_stations() -> None:
    """Other names, the same one twice, and a pair that was not searched yet are refused."""
    record = atlas(pair("a", "b"))
    assert record.pair("a", "b") is record.pairs[0]
    for names, words in ((("a", "d"), "it has a, b, c"), (("a", "a"), "two stations"), (("b", "a"), "interrupted")):
        with pytest.raises(UsageError, match=words):
            record.pair(*names)


def test_a_record_is_read_back_as_it_was_written() -> None:
    """The keys of the file are `from` and `to`."""
    record = atlas(pair("a", "b", motion=MotionRecord(status="done", run="r", duration_s=2.0)))
    assert AtlasRecord.model_validate_json(record.model_dump_json()) == record
    assert record.model_dump(mode="json")["pairs"][0]["from"] == "a"
