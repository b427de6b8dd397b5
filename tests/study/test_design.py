"""Designs: which points a study has, and that they are the same each time."""

from typing import Any

import numpy as np
import pytest

from pipeline.errors import ConfigError
from pipeline.study.config import StudyConfig, parse_study
from pipeline.study.design import count_points, points

A, B = {"key": "a", "values": [1, 2, 3]}, {"key": "b", "values": ["x", "y"]}
RANGE = {"key": "r", "min": 1.0, "max": 100.0}


def study(kind: str, *parameters: dict[str, Any], **design: Any) -> StudyConfig:
    """Make a study of a kind."""
    return parse_study({"base": "-", "design": {"kind": kind, **design}, "parameters": list(parameters)})


def test_a_grid_has_every_combination_and_the_last_varies_fastest() -> None:
    """Keys that go together stay together."""
    both = {"keys": ["s", "g"], "values": [["L", "R"], ["R", "L"]]}
    found = list(points(study("grid", A, both)))
    assert len(found) == count_points(study("grid", A, both)) == 6
    assert found[:3] == [{"a": 1, "s": "L", "g": "R"}, {"a": 1, "s": "R", "g": "L"}, {"a": 2, "s": "L", "g": "R"}]


def test_zipped_values_go_together_and_are_equally_many() -> None:
    """The first with the first, the second with the second."""
    assert list(points(study("zipped", {**A, "values": [1, 2]}, B))) == [{"a": 1, "b": "x"}, {"a": 2, "b": "y"}]
    with pytest.raises(ConfigError, match="a has 3, b has 2"):
        count_points(study("zipped", A, B))


def test_a_list_is_taken_as_it_is() -> None:
    """Points may have different keys."""
    listed = [{"a": 1}, {"b": 2}]
    given = parse_study({"base": "-", "design": {"kind": "list"}, "points": listed})
    assert list(points(given)) == listed
    assert count_points(given) == 2


def test_ranges_reach_both_ends_in_even_steps() -> None:
    """Linear, or by equal factors; without digits that only rounding has made."""
    tenths = {"key": "r", "min": 0.1, "max": 0.5, "count": 5}
    assert [point["r"] for point in points(study("grid", tenths))] == [0.1, 0.2, 0.3, 0.4, 0.5]
    assert [point["r"] for point in points(study("grid", {**RANGE, "count": 3, "log": True}))] == [1.0, 10.0, 100.0]


@pytest.mark.parametrize("kind", ["random", "sobol"])
def test_drawn_points_follow_from_the_seed(kind: str) -> None:
    """The same seed gives the same points, within the ranges and among the values; another seed others."""
    first, same, other = (list(points(study(kind, RANGE, B, samples=9, seed=seed))) for seed in (1, 1, 2))
    assert first == same != other
    assert all(1.0 <= float(str(point["r"])) <= 100.0 and point["b"] in ("x", "y") for point in first)


def test_an_optimisation_has_no_points_in_advance() -> None:
    """How many there are is known."""
    given = parse_study(
        {"base": "-", "design": {"kind": "optimise", "samples": 7}, "parameters": [RANGE], "pareto": ["f"]}
    )
    assert count_points(given) == 7
    with pytest.raises(ValueError, match="follow from its results"):
        next(points(given))


def test_sobol_points_fill_a_range_evenly() -> None:
    """Of 2^k points every one of 2^k equal intervals has one."""
    found = [point["r"] for point in points(study("sobol", RANGE, B, samples=16))]
    assert (np.histogram(np.array(found, dtype=float), 16, (1.0, 100.0))[0] == 1).all()
