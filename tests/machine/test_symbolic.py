"""The CasADi functions against their NumPy counterparts, and their derivatives against finite differences."""

from collections.abc import Callable

import casadi as ca
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.arrays import FloatArray
from pipeline.machine import Machine, statics_matrix
from pipeline.machine.geometry import cart_joints, link_lengths, link_vectors, platform_arms
from pipeline.machine.kinematics import closure_jacobian
from pipeline.machine.symbolic import closure_function, joints_function, statics_function, statics_terms_function

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(["on axis", "off axis", "general"])


def over(function: ca.Function, pose: FloatArray, q: FloatArray) -> list[FloatArray]:
    """Evaluate a function at poses (n, 6) and actuators (n, 5); one array (n, ...) per output."""
    shapes = [function.size_out(k) for k in range(function.n_out())]
    outputs = function.map(len(pose)).call([ca.DM(pose.T), ca.DM(q.T)])
    return [
        np.array(output).reshape(rows, len(pose), columns).transpose(1, 0, 2)
        for output, (rows, columns) in zip(outputs, shapes, strict=True)
    ]


@given(seed=seeds, kind=kinds)
@settings(max_examples=15)
def test_joints_closure_and_statics_are_those_of_numpy(
    draw_machine: Callable, draw_poses: Callable, seed: int, kind: str
):
    """At poses that close and at poses that do not, for any machine, CasADi and NumPy agree."""
    machine = draw_machine(seed, kind)
    sample = draw_poses(machine, seed)
    for q in (sample.q_m, sample.q_m + np.linspace(-0.02, 0.03, 5)):
        carts = q[:, :3]
        platform, cart = over(joints_function(machine), sample.pose, q)
        expected = sample.pose[:, None, :3] + platform_arms(machine, sample.pose)
        np.testing.assert_allclose(platform, expected, atol=1e-14)
        np.testing.assert_allclose(cart, cart_joints(machine, carts), atol=1e-14)
        (H,) = over(statics_function(machine), sample.pose, q)
        np.testing.assert_allclose(H, statics_matrix(machine, sample.pose, carts), atol=1e-13)
        (residual,) = over(closure_function(machine), sample.pose, q)
        squares = np.sum(link_vectors(machine, sample.pose, carts) ** 2, axis=2)
        scale = 2.0 * link_lengths(machine, machine.strokes_m.mean(axis=1))
        expected = (squares - link_lengths(machine, q[:, 3:]) ** 2) / scale
        np.testing.assert_allclose(residual[:, :, 0], expected, atol=1e-13)


def test_closure_derivative_is_the_closure_jacobian(machine: Machine, reference_solution):
    """Where links have their lengths the polynomial residual has the derivatives of the true one."""
    function = closure_function(machine)
    pose, q = ca.SX.sym("pose", 6), ca.SX.sym("q", 5)
    jacobian = ca.Function("jacobian", [pose, q], [ca.jacobian(function(pose, q), pose)])
    (J,) = over(jacobian, reference_solution.pose, reference_solution.q_m)
    ratio = link_lengths(machine, reference_solution.q_m[:, 3:]) / link_lengths(machine, machine.strokes_m.mean(axis=1))
    expected = closure_jacobian(machine, reference_solution.pose, reference_solution.q_m) * ratio[:, :, None]
    np.testing.assert_allclose(J, expected, atol=1e-13)


def test_statics_terms_are_the_derivatives_of_the_statics_matrix(machine: Machine, reference_solution):
    """Central differences of H by pose and carts agree, and those of W . H by the first derivatives for any W."""
    row, W = 11, np.random.default_rng(8).normal(size=36)
    terms = statics_terms_function(machine)
    at = np.concatenate([reference_solution.pose[row], reference_solution.q_m[row, :3]])

    def entries(z: FloatArray) -> FloatArray:
        return statics_matrix(machine, z[:6], z[6:]).T.ravel()

    steps = 1e-6 * np.eye(9)
    first = np.stack([(entries(at + h) - entries(at - h)) / 2e-6 for h in steps], axis=1)
    np.testing.assert_allclose(np.array(terms(at, W)[0]), first, atol=1e-8)
    second = (
        np.stack([(np.array(terms(at + h, W)[0]).T @ W - np.array(terms(at - h, W)[0]).T @ W) for h in steps]) / 2e-6
    )
    np.testing.assert_allclose(np.array(terms(at, W)[1]), second, atol=1e-7)
