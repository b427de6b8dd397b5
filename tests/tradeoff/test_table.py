"""Trade-offs as text and as data."""

import json

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.tradeoff import TABLE_HEADER, MissingPoint, Tradeoff, missing_text, table_cells, tradeoff_data
from tests.tradeoff.conftest import make_point


def test_cells_fill_the_header() -> None:
    """The first point is what the others are compared with, in per cent."""
    first, other = table_cells([make_point(), make_point(2, 3.0)])
    assert len(first) == len(other) == len(TABLE_HEADER)
    assert first == ("1", "no time", "6.000", "", "400.0", "", "29.90", "30.00", "9", "LLL RRR")
    assert other == ("2", "3", "5.750", "-4.2", "500.0", "+25.0", "32.40", "32.50", "9", "LLL RRR")


def test_what_is_missing_is_named() -> None:
    """By route and weight; a whole route by its rank."""
    error = NoSolutionError("refine", "no path", "another corridor")
    assert missing_text(MissingPoint(2, 0.3, error)) == "route 2, weight 0.3: no path"
    assert missing_text(MissingPoint(2, None, error)) == "route 2: no path"


def test_data_are_json(quick_config: Config) -> None:
    """Unrounded, with the proof of every point, and the reasons of those that are missing."""
    error = NoSolutionError("certify", "too near", "more clearance")
    points = (make_point(), make_point(1, 0.3))
    data = json.loads(json.dumps(tradeoff_data(quick_config, Tradeoff(points, (MissingPoint(2, None, error),)))))
    assert data["name"] == "quick"
    assert [point["weight"] for point in data["points"]] == [None, 0.3]
    assert data["points"][1]["duration_s"] == points[1].duration_s
    assert {point["verdict"] for point in data["points"]} == {"certified"}
    assert data["missing"] == [
        {"route": 2, "weight": None, "stage": "certify", "reason": "too near", "advice": "more clearance"}
    ]
