"""What a sampler chooses from, and the points that its choices stand for."""

from typing import Any

import optuna
import pytest

from pipeline.study.config import StudyConfig, parse_study
from pipeline.study.optimise.space import choice_of, distributions, point_of

RANGE = {"key": "a.length_m", "min": 1.0, "max": 2.0}
PAIRS = {"keys": ["s", "g"], "values": [["L", "R"], ["R", "L"]]}


def study(*parameters: dict[str, Any]) -> StudyConfig:
    """Make an optimisation of some parameters."""
    design = {"kind": "optimise", "samples": 9}
    return parse_study({"base": "-", "design": design, "parameters": list(parameters), "pareto": ["f"]})


def test_a_choice_stands_for_the_values_of_all_keys() -> None:
    """Keys that vary together are one parameter; numbers keep 12 digits, and stay within their range."""
    both = study(RANGE, PAIRS)
    assert point_of(both, {"a.length_m": 1.0 + 1e-13, "s": 1}) == {"a.length_m": 1.0, "s": "R", "g": "L"}
    edge = study({"key": "a", "min": 1.0, "max": 1.9999999999999})
    assert point_of(edge, {"a": 1.9999999999999}) == {"a": 1.9999999999999}


def test_optuna_is_told_ranges_and_lists() -> None:
    """A list has no order; a range may be logarithmic."""
    kinds = optuna.distributions
    assert distributions(study({**RANGE, "log": True}, PAIRS)) == {
        "a.length_m": kinds.FloatDistribution(1.0, 2.0, log=True),
        "s": kinds.CategoricalDistribution((0, 1)),
    }


@pytest.mark.parametrize(
    ("base", "choice"),
    [
        ({"a": {"length_m": 1.5}, "s": "R", "g": "L"}, {"a.length_m": 1.5, "s": 1}),
        ({"a": {"length_m": 2.5}, "s": "R", "g": "L"}, None),
        ({"a": {"length_m": None}, "s": "R", "g": "L"}, None),
        ({"a": {"length_m": 1.5}, "s": "R", "g": "R"}, None),
    ],
)
def test_the_configuration_as_it_is_may_be_a_choice(base: dict[str, Any], choice: dict[str, Any] | None) -> None:
    """Where all of its values are in the ranges and lists; it stands for itself then."""
    both = study(RANGE, PAIRS)
    assert choice_of(both, base) == choice
    if choice is not None:
        assert point_of(both, choice) == {"a.length_m": 1.5, "s": "R", "g": "L"}
