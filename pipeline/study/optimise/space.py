"""The space of an optimisation: what a sampler chooses from, and the points that its choices stand for."""

from collections.abc import Mapping
from typing import Any

from pipeline.study.config import ParameterConfig, StudyConfig
from pipeline.study.design import Point, listed
from pipeline.study.extra import library
from pipeline.study.keys import value_at

Choice = dict[str, Any]
"""What a sampler chooses, by the first key of each parameter: a number of a range, or the place of a listed value."""

_DIGITS = 12


def distributions(study: StudyConfig) -> dict[str, Any]:
    """Describe the parameters to Optuna: ranges, and lists of values without an order."""
    kinds = library("optuna.distributions")
    return {
        one.paths[0]: kinds.CategoricalDistribution(range(len(one.values)))
        if one.values
        else kinds.FloatDistribution(one.min, one.max, log=one.log)
        for one in study.parameters
    }


def point_of(study: StudyConfig, choice: Mapping[str, Any]) -> Point:
    """Look up the values that a choice stands for; numbers of ranges are rounded to 12 digits."""
    point: Point = {}
    for one in study.parameters:
        chosen = choice[one.paths[0]]
        point |= listed(one)[chosen] if one.values else {one.paths[0]: _rounded(one, chosen)}
    return point


def choice_of(study: StudyConfig, base: Mapping[str, Any]) -> Choice | None:
    """Give the choice that stands for the configuration as it is; None if that is not in the space."""
    choice: Choice = {}
    for one in study.parameters:
        values = {path: value_at(base, path) for path in one.paths}
        if one.values:
            places = [place for place, point in enumerate(listed(one)) if point == values]
            if not places:
                return None
            choice[one.paths[0]] = places[0]
        else:
            value = values[one.paths[0]]
            low, high = one.min, one.max
            if not isinstance(value, int | float) or low is None or high is None or not low <= value <= high:
                return None
            choice[one.paths[0]] = float(value)
    return choice


def _rounded(parameter: ParameterConfig, value: float) -> float:
    low, high = parameter.min, parameter.max
    rounded = float(f"{value:.{_DIGITS}g}")
    return rounded if low is None or high is None else min(max(rounded, low), high)
