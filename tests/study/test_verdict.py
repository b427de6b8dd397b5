"""Which runs count, and how far the others are from it."""

import pytest

from pipeline.study.config import StudyConfig, parse_study
from pipeline.study.rows import Ending, Row
from pipeline.study.verdict import shortfall, violation


def study(kind: str = "grid") -> StudyConfig:
    """Make a study with a bound on both sides."""
    optimise = kind == "optimise"
    design = {"kind": kind, **({"samples": 9} if optimise else {})}
    values = {"key": "a", "min": 1, "max": 2, **({} if optimise else {"count": 2})}
    bounds = [{"figure": "f", "min": 2.0, "max": 4.0}]
    return parse_study({"base": "-", "design": design, "parameters": [values], "pareto": ["-g"], "constraints": bounds})


@pytest.mark.parametrize(
    ("figures", "said", "excess"),
    [
        ({"f": 2.0}, "", 0.0),
        ({"f": 5.0}, "f above 4", 0.25),
        ({"f": 1.0}, "f below 2", 0.5),
        ({"f": float("nan")}, "no f", 1e6),
        ({}, "no f", 1e6),
    ],
)
def test_bounds_are_those_of_the_file(figures: dict[str, float], said: str, excess: float) -> None:
    """The excess is relative to the bound, so that figures of different size can be added."""
    row = Row("k", Ending.DONE, figures=figures)
    assert (shortfall(study(), row), violation(study(), row)) == (said, excess)


def test_an_optimisation_needs_what_it_optimises() -> None:
    """A run without it does not count there; elsewhere the Pareto front alone leaves it out."""
    row = Row("k", Ending.DONE, figures={"f": 3.0})
    assert shortfall(study(), row) == ""
    assert shortfall(study("optimise"), row) == "no g"
    assert violation(study("optimise"), row) == 1e6


def test_a_run_without_a_result_is_worse_than_any_excess() -> None:
    """Its reason is its own."""
    failed = Row("k", Ending.NO_SOLUTION, "no route", figures={"f": 3.0})
    assert shortfall(study(), failed) == "no route"
    assert violation(study(), failed) > violation(study(), Row("k", Ending.DONE, figures={"f": 1e30}))
