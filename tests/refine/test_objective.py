"""Objectives of stage two."""

import pytest

from pipeline.config.choices import PathObjective
from pipeline.refine.measure import KappaFigures
from pipeline.refine.objective import OBJECTIVES

FIGURES = KappaFigures(kappa_max=30.0, kappa_integral=400.0)


def test_every_objective_of_the_configuration_has_a_row() -> None:
    """And no other has one."""
    assert set(OBJECTIVES) == set(PathObjective)


@pytest.mark.parametrize(("name", "value"), [("integral", 400.0), ("mixed", 20.0 + 30.0), ("maximum", 30.0)])
def test_what_is_minimised_is_its_formula(name: str, value: float) -> None:
    """The integral, its mean over the length of the coarse path plus the largest kappa, the largest kappa."""
    assert OBJECTIVES[name].minimised(FIGURES, 20.0) == value
