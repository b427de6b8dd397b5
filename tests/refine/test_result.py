"""Paths that can be evaluated anywhere."""

import numpy as np
import pytest

from pipeline.errors import ForwardKinematicsError
from pipeline.machine.kinematics import closure_residual
from pipeline.refine import Path, Refinement


def test_the_pose_closes_all_links_anywhere(refinement: Refinement) -> None:
    """Forward kinematics holds between the nodes, too."""
    s = np.random.default_rng(1).uniform(0.0, 1.0, 500)
    path = refinement.path
    assert np.abs(closure_residual(path.machine, path.pose(s), path.q(s))).max() < 1e-10


def test_poses_have_the_shape_of_their_parameters(refinement: Refinement) -> None:
    """One number gives one pose and one row of actuators, an array of any shape as many."""
    path = refinement.path
    s = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
    assert (path.pose(0.5).shape, path.q(0.5).shape) == ((6,), (5,))
    assert (path.pose(s).shape, path.q(s).shape) == ((2, 3, 6), (2, 3, 5))
    np.testing.assert_allclose(path.pose(s)[1, 1], path.pose(0.5), atol=1e-12)


def test_derivatives_of_q_agree_with_differences(refinement: Refinement) -> None:
    """First and second derivative against central differences."""
    path, s, h = refinement.path, np.linspace(0.05, 0.95, 50), 1e-5
    np.testing.assert_allclose(path.q(s, 1), (path.q(s + h) - path.q(s - h)) / (2 * h), atol=1e-6)
    np.testing.assert_allclose(path.q(s, 2), (path.q(s + h, 1) - path.q(s - h, 1)) / (2 * h), atol=1e-4)


def test_a_path_whose_links_cannot_close_says_so(coarse: Path) -> None:
    """Actuators far from any pose are refused with the amount the links miss."""
    spline = type(coarse.spline)(coarse.spline.t, coarse.spline.c + [0.0, 0.0, 5.0, 0.0, 0.0], 1)
    broken = Path(coarse.machine, spline, coarse.node_s, coarse.node_pose)
    with pytest.raises(ForwardKinematicsError, match="miss their lengths"):
        broken.pose(np.array([0.5]))
