"""The CasADi functions against their NumPy counterparts, and their derivatives against finite differences."""

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.machine import Machine, condition_number, statics_matrix
from pipeline.machine.geometry import FloatArray, cart_joints, link_lengths, link_vectors, platform_arms
from pipeline.machine.kinematics import closure_jacobian
from pipeline.machine.symbolic import closure_function, joints_function, kappa_function, statics_function

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(["on axis", "off axis", "general"])
smooth = pytest.mark.parametrize("kind", ["schatten", "frobenius"])


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


@given(seed=seeds, kind=kinds)
@settings(max_examples=15)
def test_smooth_condition_numbers_are_what_they_say(draw_machine: Callable, draw_poses: Callable, seed: int, kind: str):
    """Frobenius is |H| |H^-1|; Schatten is the 64-norm's and lies within 6 per cent above kappa_2."""
    machine = draw_machine(seed, kind)
    sample = draw_poses(machine, seed, kappa_max=200.0)
    H = statics_matrix(machine, sample.pose, sample.q_m[:, :3])
    singular = np.linalg.svd(H, compute_uv=False)
    frobenius = over(kappa_function(machine, "frobenius"), sample.pose, sample.q_m)[0].ravel()
    expected = np.linalg.norm(H, axis=(1, 2)) * np.linalg.norm(np.linalg.inv(H), axis=(1, 2))
    np.testing.assert_allclose(frobenius, expected, rtol=1e-9)
    schatten = over(kappa_function(machine, "schatten"), sample.pose, sample.q_m)[0].ravel()
    expected = np.linalg.norm(singular, ord=64, axis=1) * np.linalg.norm(1.0 / singular, ord=64, axis=1)
    np.testing.assert_allclose(schatten, expected, rtol=1e-9)
    kappa = condition_number(H)
    assert (schatten >= kappa * (1.0 - 1e-9)).all()
    assert (schatten <= kappa * 1.06).all()
    assert (frobenius >= schatten * (1.0 - 1e-9)).all()


def test_closure_derivative_is_the_closure_jacobian(machine: Machine, reference_solution):
    """Where links have their lengths the polynomial residual has the derivatives of the true one."""
    function = closure_function(machine)
    pose, q = ca.SX.sym("pose", 6), ca.SX.sym("q", 5)
    jacobian = ca.Function("jacobian", [pose, q], [ca.jacobian(function(pose, q), pose)])
    (J,) = over(jacobian, reference_solution.pose, reference_solution.q_m)
    ratio = link_lengths(machine, reference_solution.q_m[:, 3:]) / link_lengths(machine, machine.strokes_m.mean(axis=1))
    expected = closure_jacobian(machine, reference_solution.pose, reference_solution.q_m) * ratio[:, :, None]
    np.testing.assert_allclose(J, expected, atol=1e-13)


@smooth
def test_gradient_agrees_with_finite_differences(machine: Machine, reference_solution, kind: str):
    """Central differences of kappa agree with CasADi's gradient in pose and actuators."""
    function = kappa_function(machine, kind)
    x = ca.SX.sym("x", 11)
    gradient = ca.Function("gradient", [x], [ca.gradient(function(x[:6], x[6:]), x)])
    for row in (0, 11, 23, 38):
        at = np.concatenate([reference_solution.pose[row], reference_solution.q_m[row]])
        differences = [
            float(function(*np.split(at + h, [6])) - function(*np.split(at - h, [6]))) / 2e-6 for h in 1e-6 * np.eye(11)
        ]
        found = np.array(gradient(at)).ravel()
        np.testing.assert_allclose(found, differences, atol=1e-6 * np.abs(found).max())


@smooth
def test_kappa_depends_on_neither_x_nor_telescopes(machine: Machine, reference_solution, kind: str):
    """Shifting platform and carts together changes nothing, nor does a telescope alone."""
    function = kappa_function(machine, kind)
    pose, q = reference_solution.pose, reference_solution.q_m
    before = over(function, pose, q)[0]
    shifted = over(function, pose + np.array([0.7, 0, 0, 0, 0, 0]), q + np.array([0.7, 0.7, 0.7, 0.1, -0.1]))[0]
    np.testing.assert_allclose(shifted, before, rtol=1e-10)


@smooth
def test_second_derivatives_leave_out_the_telescopes(machine: Machine, kind: str):
    """Their rows and columns of the Hessian are empty by structure, which an optimiser can use."""
    x = ca.SX.sym("x", 11)
    hessian, _ = ca.hessian(kappa_function(machine, kind)(x[:6], x[6:]), x)
    assert hessian[9:, :].nnz() == 0
    assert hessian[:9, :9].nnz() == 81


@pytest.mark.parametrize(("kind", "most"), [("frobenius", 800), ("schatten", 3200)])
def test_expressions_stay_lean(machine: Machine, kind: str, most: int):
    """The number of operations does not explode, as it does with a symbolic inverse or determinant."""
    assert kappa_function(machine, kind).n_instructions() < most


@smooth
def test_large_condition_numbers_do_not_overflow(machine: Machine, kind: str):
    """Near a singularity, where powers of H'H range over many orders, value and gradient stay finite and right."""
    pose = np.array([1.0, 1.14, 0.02, 0.0, 0.7, 0.0])
    q = np.array([0.3, 0.4, 1.0, 1.0, 1.2])
    H = statics_matrix(machine, pose, q[:3])
    kappa = float(condition_number(H))
    assert kappa > 1e3
    function = kappa_function(machine, kind)
    x = ca.SX.sym("x", 11)
    gradient = ca.Function("gradient", [x], [ca.gradient(function(x[:6], x[6:]), x)])
    assert float(function(pose, q)) == pytest.approx(kappa, rel=1.0 if kind == "frobenius" else 0.06)
    assert np.isfinite(np.array(gradient(np.concatenate([pose, q])))).all()
