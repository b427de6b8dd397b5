"""Objectives of stage two."""

import pytest

from pipeline.config.choices import PathObjective
from pipeline.refine import PathFigures
from pipeline.refine.objective import OBJECTIVES

FIGURES = PathFigures(
    kappa_max=30.0,
    kappa_max_s=0.5,
    kappa_integral=400.0,
    length=21.0,
    closure_residual_m=0.0,
    measures={},
    det_sign_constant=True,
    modes=("LLL",),
    actuator_length_m=3.0,
    actuator_distance_m=2.0,
)


def test_every_objective_of_the_configuration_has_a_row() -> None:
    """And no other has one."""
    assert set(OBJECTIVES) == set(PathObjective)


@pytest.mark.parametrize(("name", "value"), [("integral", 400.0), ("mixed", 20.0 + 30.0), ("maximum", 30.0)])
def test_what_is_minimised_is_its_formula(name: str, value: float) -> None:
    """The integral, its mean over the length of the coarse path plus the largest kappa, the largest kappa."""
    assert OBJECTIVES[name].minimised(FIGURES, 20.0) == value
