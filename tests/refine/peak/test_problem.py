"""The objective of a descent, and what its iterates have to keep."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from pipeline.refine.peak.iterate import Iterate
from pipeline.refine.peak.problem import PeakObjective, PeakProblem


def test_the_largest_kappa_counts_above_its_target_only(iterate: Iterate) -> None:
    """Weights of the mean over the length, and of the largest kappa or the target, whichever is larger."""
    peak = float(iterate.kappa.max())
    for target, expected in ((0.5 * peak, peak), (2.0 * peak, 2.0 * peak)):
        value = PeakObjective(2.0, 3.0, target, np.inf, 12.0, csr_array((80, 80))).value(iterate)
        assert value == pytest.approx(2.0 * iterate.integral / 12.0 + 3.0 * expected)


def test_the_excess_is_that_of_the_worst_constraint(peak: PeakProblem, iterate: Iterate) -> None:
    """In units of its slack."""
    assert peak.excess(iterate) == max(constraint.excess for constraint in peak.constraints(iterate))
