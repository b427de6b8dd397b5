"""Iterates of the descent: forward kinematics at the evaluation points, and derivatives by the actuators there."""

import numpy as np
import pytest

from pipeline.machine.kinematics import closure_residual
from pipeline.refine.peak.iterate import EvaluationPoints, Iterate, iterate_at
from pipeline.route.metric import arc_length

H = 1e-6


def _beside(points: EvaluationPoints, iterate: Iterate, direction: np.ndarray, step: float) -> Iterate:
    tried = iterate_at(points, iterate.coefficients + step * direction, iterate.samples.pose)
    assert tried is not None
    return tried


def test_every_point_closes_all_links(points: EvaluationPoints, iterate: Iterate) -> None:
    """The pose is the one that the actuators force."""
    assert np.abs(closure_residual(points.machine, iterate.samples.pose, iterate.samples.q_m)).max() < 1e-9


def test_kappa_is_just_above_the_true_one(points: EvaluationPoints, iterate: Iterate) -> None:
    """A Schatten norm of exponent 64 is at most six per cent above."""
    kappa = iterate.samples.kappa
    assert (iterate.kappa >= kappa * (1.0 - 1e-12)).all()
    assert (iterate.kappa <= 1.06 * kappa).all()


def test_the_integral_is_the_trapezoidal_one(points: EvaluationPoints, iterate: Iterate) -> None:
    """Over the length in the metric of the route."""
    expected = np.trapezoid(iterate.kappa, arc_length(iterate.samples.pose, points.steps))
    assert iterate.integral == pytest.approx(expected, rel=1e-12)


def test_derivatives_by_the_actuators_agree_with_differences(
    points: EvaluationPoints, iterate: Iterate, direction: np.ndarray
) -> None:
    """Poses and kappa of coefficients moved either way along a random direction."""
    ahead, behind = (_beside(points, iterate, direction, step) for step in (H, -H))
    dq = (ahead.samples.q_m - behind.samples.q_m) / (2.0 * H)
    found = np.einsum("kij,kj->ki", iterate.moves, dq)
    np.testing.assert_allclose(
        found, (ahead.samples.pose - behind.samples.pose) / (2.0 * H), atol=1e-6 * np.abs(found).max()
    )
    found = np.sum(iterate.kappa_slope * dq, axis=1)
    np.testing.assert_allclose(found, (ahead.kappa - behind.kappa) / (2.0 * H), atol=1e-5 * np.abs(found).max())


def test_coefficients_that_cannot_close_give_no_iterate(points: EvaluationPoints, iterate: Iterate) -> None:
    """A cart five metres away tears the machine apart."""
    assert iterate_at(points, iterate.coefficients + [0.0, 0.0, 5.0, 0.0, 0.0], iterate.samples.pose) is None


def test_differences_at_some_points_are_those_at_all(iterate: Iterate) -> None:
    """Of whatever values there are at a pose, in whatever order the points are given."""
    some = np.array([4, 1, 7])
    np.testing.assert_array_equal(
        iterate.slopes_at(some, lambda samples: samples.reach_m), iterate.slopes(lambda samples: samples.reach_m)[some]
    )
