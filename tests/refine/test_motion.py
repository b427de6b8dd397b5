"""The pose along a path, differentiated."""

import numpy as np
import pytest

from pipeline.errors import NoSolutionError
from pipeline.machine import condition_number, statics_matrix
from pipeline.refine import Path, Refinement
from pipeline.refine.motion import kappa_along, pose_derivatives, pose_spline

S = np.linspace(0.02, 0.98, 61)


def test_derivatives_of_the_pose_agree_with_differences(refinement: Refinement) -> None:
    """Each of the three against central differences of the one before."""
    path, h = refinement.path, 1e-5
    pose, *derivatives = pose_derivatives(path, S)
    np.testing.assert_array_equal(pose, path.pose(S))
    before, after = pose_derivatives(path, S - h), pose_derivatives(path, S + h)
    for order, derivative in enumerate(derivatives):
        expected = (after[order] - before[order]) / (2.0 * h)
        np.testing.assert_allclose(derivative, expected, atol=1e-6 * np.abs(expected).max())


def test_derivatives_along_a_straight_line_in_actuator_space(coarse: Path) -> None:
    """Within one move the actuators run straight on, and the pose still bends."""
    corners = coarse.spline.t[1:-1]
    s, h = (corners[:-1] + corners[1:]) / 2.0, 1e-5
    pose, _, second, _ = pose_derivatives(coarse, s)
    expected = (coarse.pose(s + h) - 2.0 * pose + coarse.pose(s - h)) / h**2
    np.testing.assert_allclose(second, expected, atol=1e-3 * np.abs(expected).max())


def test_kappa_anywhere_is_that_of_the_statics_matrix(refinement: Refinement) -> None:
    """For one s and for many."""
    path = refinement.path
    H = statics_matrix(path.machine, path.pose(S), path.q(S)[:, :3])
    np.testing.assert_allclose(kappa_along(path, S), condition_number(H))
    assert kappa_along(path, 0.5).shape == (1,)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_the_pose_spline_keeps_its_tolerance(refinement: Refinement, tolerance: float) -> None:
    """Off its own samples, and exactly at both ends."""
    path = refinement.path
    spline = pose_spline(path, tolerance, tolerance)
    s, columns = np.linspace(0.0, 1.0, 3_001), [0, 1, 2, 3, 5]
    assert np.abs(spline(s) - path.pose(s)[:, columns]).max() <= 1.2 * tolerance
    np.testing.assert_allclose(spline([0.0, 1.0]), path.pose(np.array([0.0, 1.0]))[:, columns], atol=1e-12)


def test_a_tolerance_below_rounding_is_refused(refinement: Refinement) -> None:
    """What the best spline reached is in the message."""
    with pytest.raises(NoSolutionError, match=r"off by .* m and .* rad"):
        pose_spline(refinement.path, 0.0, 0.0)
