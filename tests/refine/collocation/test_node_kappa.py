"""Kappa of the nodes as a function of CasADi, against finite differences of NumPy's."""

import casadi as ca
import numpy as np
import pytest

from pipeline.machine import Machine, condition_number, statics_matrix
from pipeline.refine import Path
from pipeline.refine.collocation.node_kappa import UNKNOWNS, NodeKappa

_STEP = 1e-5


@pytest.fixture(scope="module")
def nodes(coarse: Path) -> np.ndarray:
    """Pose and carts at a few places of the coarse path, a column each."""
    rows = np.array([0, 231, 517, 803])
    return np.hstack([coarse.node_pose[rows], coarse.q(coarse.node_s[rows])[:, :3]]).T


@pytest.mark.parametrize("exponent", [2.0, 64.0])
def test_derivatives_agree_with_finite_differences(machine: Machine, nodes: np.ndarray, exponent: float) -> None:
    """Gradients by central differences of kappa, second derivatives by those of the gradients."""
    kappa = NodeKappa(machine, nodes.shape[1], exponent)
    value, slope, bend = (np.array(part) for part in kappa(nodes))
    blocks = bend.reshape(UNKNOWNS, nodes.shape[1], UNKNOWNS)
    for axis in range(UNKNOWNS):
        step = np.zeros((UNKNOWNS, 1))
        step[axis] = _STEP
        ahead, behind = (kappa(nodes + sign * step) for sign in (1.0, -1.0))
        np.testing.assert_allclose(
            (np.array(ahead[0]) - np.array(behind[0]))[0] / (2 * _STEP), slope[axis], atol=1e-5 * value.max()
        )
        differences = (np.array(ahead[1]) - np.array(behind[1])) / (2 * _STEP)
        np.testing.assert_allclose(differences, blocks[:, :, axis], atol=1e-4 * np.abs(bend).max())


def test_it_is_close_above_the_true_one(machine: Machine, nodes: np.ndarray) -> None:
    """At exponent 64 within 6 per cent."""
    value = np.array(NodeKappa(machine, nodes.shape[1], 64.0)(nodes)[0])[0]
    true = condition_number(statics_matrix(machine, nodes[:6].T, nodes[6:].T))
    assert (value >= true).all()
    assert (value <= 1.06 * true).all()


def test_kappa_does_not_change_along_the_rails(machine: Machine, nodes: np.ndarray) -> None:
    """Platform and carts shifted together by the same x: no slope, no curvature."""
    _, slope, bend = (np.array(part) for part in NodeKappa(machine, nodes.shape[1], 64.0)(nodes))
    along = np.zeros(UNKNOWNS)
    along[[0, 6, 7, 8]] = 1.0
    np.testing.assert_allclose(along @ slope, 0.0, atol=1e-9 * np.abs(slope).max())
    np.testing.assert_allclose(along @ bend, 0.0, atol=1e-9 * np.abs(bend).max())


def test_kappa_of_a_point_that_is_not_finite_is_nan(machine: Machine, nodes: np.ndarray) -> None:
    """A solver that steps too far notices, and may step back."""
    lost = nodes.copy()
    lost[0, 0] = np.nan
    assert all(np.isnan(np.array(part)).all() for part in NodeKappa(machine, nodes.shape[1], 64.0)(ca.DM(lost)))
