"""Whether a run counts: it has a result, the figures that are optimised, and keeps the constraints."""

import math
from collections.abc import Mapping
from typing import Any

from pipeline.study.config import ConstraintConfig, Kind, StudyConfig
from pipeline.study.rows import Ending, Row

_NO_RESULT = 1e6
"""Violation of a run without a result: every run with one is better."""


def shortfall(study: StudyConfig, row: Row) -> str:
    """Say in a few words why a run does not count; empty if it does."""
    if row.ending != Ending.DONE:
        return row.reason
    missing = [name for name in _objectives(study) if number(row.figures, name) is None]
    if missing:
        return f"no {missing[0]}"
    return next((text for one in study.constraints if (text := _broken(one, row.figures))), "")


def violation(study: StudyConfig, row: Row) -> float:
    """Measure how far a run is from counting; 0 if it does.

    The excess over every bound per size of the bound, summed up; without a result or one of the figures 1e6, so that
    a sampler prefers a run that breaks a constraint to one that has no motion.
    """
    if not shortfall(study, row):
        return 0.0
    figures = [number(row.figures, one.figure) for one in study.constraints]
    if row.ending != Ending.DONE or None in figures or any(number(row.figures, n) is None for n in _objectives(study)):
        return _NO_RESULT
    excess = sum(
        _excess(one, value) for one, value in zip(study.constraints, figures, strict=True) if value is not None
    )
    return min(excess, 0.5 * _NO_RESULT)


def number(figures: Mapping[str, Any], name: str) -> float | None:
    """Give a figure; None if there is none that is a finite number."""
    value = figures.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return float(value)


def _objectives(study: StudyConfig) -> tuple[str, ...]:
    wanted = study.pareto if study.design.kind is Kind.OPTIMISE else ()
    return tuple(name.removeprefix("-") for name in wanted)


def _broken(constraint: ConstraintConfig, figures: Mapping[str, Any]) -> str:
    value = number(figures, constraint.figure)
    if value is None:
        return f"no {constraint.figure}"
    if constraint.min is not None and value < constraint.min:
        return f"{constraint.figure} below {constraint.min:g}"
    if constraint.max is not None and value > constraint.max:
        return f"{constraint.figure} above {constraint.max:g}"
    return ""


def _excess(constraint: ConstraintConfig, value: float) -> float:
    below = 0.0 if constraint.min is None else (constraint.min - value) / (abs(constraint.min) or 1.0)
    above = 0.0 if constraint.max is None else (value - constraint.max) / (abs(constraint.max) or 1.0)
    return max(below, above, 0.0)
