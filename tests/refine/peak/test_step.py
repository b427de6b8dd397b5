"""The quadratic program of a step."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from pipeline.refine.peak.constraints import by_unknowns
from pipeline.refine.peak.iterate import Iterate, iterate_at
from pipeline.refine.peak.problem import PeakObjective, PeakProblem
from pipeline.refine.peak.sqp import descend
from pipeline.refine.peak.step import StepProgram, integral_slope
from pipeline.refine.smoothness import Smoothness

SMOOTH = csr_array((80, 80))
MAXIMUM = PeakObjective(0.0, 1.0, 0.0, np.inf, 12.0, SMOOTH)
H = 1e-6


@pytest.fixture(scope="module")
def feasible(peak: PeakProblem, iterate: Iterate) -> Iterate:
    """Give an iterate that keeps every constraint: the one of least mean kappa."""
    found = descend(peak, PeakObjective(1.0, 0.0, 0.0, np.inf, 12.0, SMOOTH), iterate, 200).iterate
    assert peak.excess(found) < 1e-6
    return found


def test_the_slope_of_the_integral_agrees_with_differences(
    peak: PeakProblem, iterate: Iterate, direction: np.ndarray
) -> None:
    """Along a random change of the coefficients."""
    points = peak.points
    ahead, behind = (
        iterate_at(points, iterate.coefficients + step * direction, iterate.samples.pose) for step in (H, -H)
    )
    assert ahead is not None
    assert behind is not None
    kappa_slope = by_unknowns(points, np.arange(len(points.s)), iterate.kappa_slope)
    found = integral_slope(points, iterate, kappa_slope) @ np.append(direction.ravel(), [0.0, 0.0])
    assert found == pytest.approx((ahead.integral - behind.integral) / (2.0 * H), rel=1e-4)


def test_a_damped_step_brings_its_predicted_gain(peak: PeakProblem, feasible: Iterate) -> None:
    """Heavy damping makes a step so short that the expansion holds: the largest kappa falls as predicted."""
    change, predicted = StepProgram(peak, MAXIMUM, feasible).solve(1e6)
    assert change is not None
    assert predicted > 0.0
    np.testing.assert_allclose(change[[0, -1]], 0.0, atol=1e-9)
    tried = iterate_at(peak.points, feasible.coefficients + change, feasible.samples.pose)
    assert tried is not None
    assert MAXIMUM.value(feasible) - MAXIMUM.value(tried) == pytest.approx(predicted, rel=0.05)


def test_the_step_knows_what_is_not_smooth(peak: PeakProblem, feasible: Iterate) -> None:
    """Where smoothness alone counts, a damped step brings the gain that its slope predicts."""
    form = Smoothness(1e-3, peak.points.machine.velocity_mps).form(peak.points.knots)
    objective = PeakObjective(1.0, 0.0, 0.0, np.inf, 12.0, form)
    without = PeakObjective(1.0, 0.0, 0.0, np.inf, 12.0, SMOOTH)
    assert objective.value(feasible) > 1.5 * without.value(feasible)
    change, predicted = StepProgram(peak, objective, feasible).solve(1e6)
    assert change is not None
    tried = iterate_at(peak.points, feasible.coefficients + change, feasible.samples.pose)
    assert tried is not None
    assert predicted > 0.0
    assert objective.value(feasible) - objective.value(tried) == pytest.approx(predicted, rel=0.05)


def test_more_damping_makes_shorter_steps(peak: PeakProblem, feasible: Iterate) -> None:
    """The change of the coefficients shrinks as damping grows."""
    program = StepProgram(peak, MAXIMUM, feasible)
    sizes = []
    for damping in (1e2, 1e4, 1e6):
        change, _ = program.solve(damping)
        assert change is not None
        sizes.append(np.linalg.norm(change))
    assert sizes[0] > sizes[1] > sizes[2]
