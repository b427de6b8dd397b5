"""Lowering the largest kappa by sequential quadratic programming."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from pipeline.refine.peak.iterate import Iterate, iterate_at
from pipeline.refine.peak.problem import PeakObjective, PeakProblem
from pipeline.refine.peak.sqp import descend, restore_feasibility

NOT_SMOOTH = csr_array((80, 80))
MAXIMUM = PeakObjective(0.0, 1.0, 0.0, np.inf, 12.0, NOT_SMOOTH)


@pytest.fixture(scope="module")
def lowest(peak: PeakProblem, iterate: Iterate) -> Iterate:
    """Lower the largest kappa alone, as far as it goes."""
    descent = descend(peak, MAXIMUM, iterate, 200)
    assert descent.converged
    return descent.iterate


def test_the_largest_kappa_falls_and_all_limits_are_kept(peak: PeakProblem, iterate: Iterate, lowest: Iterate) -> None:
    """From the coarse path's splines on."""
    assert lowest.kappa.max() < 0.85 * iterate.kappa.max()
    assert peak.excess(lowest) < 1e-6


def test_no_step_in_any_direction_is_better(peak: PeakProblem, lowest: Iterate) -> None:
    """Random changes, made feasible again, never get the largest kappa lower by more than rounding."""
    rng = np.random.default_rng(1)
    for size in (1e-4, 1e-3, 1e-2) * 5:
        change = rng.normal(size=lowest.coefficients.shape) * size
        change[[0, -1]] = 0.0
        tried = iterate_at(peak.points, lowest.coefficients + change, lowest.samples.pose)
        assert tried is not None
        restored = restore_feasibility(peak, tried)
        if peak.excess(restored) < 1e-4:
            assert restored.kappa.max() > lowest.kappa.max() * (1.0 - 1e-4)


def test_feasibility_is_restored_by_the_least_change(peak: PeakProblem, lowest: Iterate) -> None:
    """A disturbed path keeps all limits again, and is no farther away than it was disturbed."""
    bump = np.zeros_like(lowest.coefficients)
    bump[6] = 0.01
    tried = iterate_at(peak.points, lowest.coefficients + bump, lowest.samples.pose)
    assert tried is not None
    assert peak.excess(tried) > 0.1
    restored = restore_feasibility(peak, tried)
    assert peak.excess(restored) < 1e-6
    assert np.abs(restored.coefficients - tried.coefficients).max() < 0.03


def test_running_out_of_steps_is_reported(peak: PeakProblem, iterate: Iterate) -> None:
    """One step does not end a descent."""
    descent = descend(peak, MAXIMUM, iterate, 1)
    assert (descent.steps, descent.converged) == (1, False)


def test_the_target_is_not_undercut_at_a_cost(peak: PeakProblem, iterate: Iterate, lowest: Iterate) -> None:
    """Above the target the largest kappa counts; with a target that is met initially the mean of kappa alone does."""
    between = 0.5 * (lowest.kappa.max() + iterate.kappa.max())
    targeted = descend(peak, PeakObjective(1.0, 10.0, between, np.inf, 12.0, NOT_SMOOTH), iterate, 200).iterate
    free = descend(
        peak, PeakObjective(1.0, 10.0, float(iterate.kappa.max()), np.inf, 12.0, NOT_SMOOTH), iterate, 200
    ).iterate
    assert targeted.kappa.max() <= between * (1.0 + 1e-6)
    assert free.integral <= targeted.integral * (1.0 + 1e-3)
    assert targeted.integral < iterate.integral
