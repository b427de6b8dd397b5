"""The equations by automatic differentiation of the closures, against those in closed form."""

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.arrays import FloatArray
from pipeline.machine import Machine
from pipeline.machine.actuator_space import (
    gravity_forces,
    gravity_stiffness,
    mass_matrix,
    velocity_damping,
    velocity_forces,
)
from pipeline.machine.actuator_space.symbolic import equations_function, linearised_function
from pipeline.machine.kinematics import pose_jacobian

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(["on axis", "off axis", "general"])


def over(function: ca.Function, *arguments: FloatArray) -> list[FloatArray]:
    """Evaluate a function at arguments (n, m); one array (n, rows, columns) per output."""
    n = len(arguments[0])
    outputs = function.map(n).call([ca.DM(argument.T) for argument in arguments])
    shapes = [function.size_out(k) for k in range(function.n_out())]
    return [
        np.array(output).reshape(rows, n, columns).transpose(1, 0, 2)
        for output, (rows, columns) in zip(outputs, shapes, strict=True)
    ]


@given(seed=seeds, kind=kinds)
@settings(max_examples=4)
def test_equations_are_those_in_closed_form(draw_moving: Callable, seed: int, kind: str):
    """Two derivations that share the geometry alone agree to rounding."""
    moving = draw_moving(seed, kind)
    machine, rates, qd = moving.machine, moving.rates, moving.qd_mps
    M, c, g, by_q = over(equations_function(machine), moving.pose, moving.q_m, qd)
    expected = (
        (M, mass_matrix(machine, rates)),
        (c[..., 0], velocity_forces(machine, rates, qd)),
        (g[..., 0], gravity_forces(machine, rates)),
        (by_q, pose_jacobian(machine, moving.pose, moving.q_m)),
    )
    for found, known in expected:
        np.testing.assert_allclose(found, known, atol=1e-8 * np.abs(known).max())


@given(seed=seeds, kind=kinds)
@settings(max_examples=3)
def test_derivatives_are_those_in_closed_form(draw_moving: Callable, seed: int, kind: str):
    """At rest dF/dq is the stiffness by gravity; in motion dF/dqd is that of the velocity terms."""
    moving = draw_moving(seed, kind)
    machine, rates, qd = moving.machine, moving.rates, moving.qd_mps
    function, rest = linearised_function(machine), np.zeros_like(qd)
    by_q, _ = over(function, moving.pose, moving.q_m, rest, rest)
    K = gravity_stiffness(machine, rates)
    np.testing.assert_allclose(by_q, K, atol=1e-8 * np.abs(K).max())
    _, by_qd = over(function, moving.pose, moving.q_m, qd, qd)
    damping = velocity_damping(machine, rates, qd)
    np.testing.assert_allclose(by_qd, damping, atol=1e-8 * np.abs(damping).max())


@given(seed=seeds, kind=kinds)
@settings(max_examples=3)
def test_stiffness_in_motion_follows_the_closures(draw_moving: Callable, seed: int, kind: str):
    """dF/dq is the difference of the forces between neighbouring poses that close, with the same qd and qdd."""
    moving, h = draw_moving(seed, kind), 1e-6
    machine, qd = moving.machine, moving.qd_mps
    qdd = qd[:, ::-1].copy()
    equations = equations_function(machine)
    by_q, _ = over(linearised_function(machine), moving.pose, moving.q_m, qd, qdd)

    def force(dq: FloatArray) -> FloatArray:
        M, c, g, _ = over(equations, *moving.at(dq), qd)
        return np.einsum("nij,nj->ni", M, qdd) + c[..., 0] + g[..., 0]

    for k in range(5):
        slope = (force(h * np.eye(5)[k]) - force(-h * np.eye(5)[k])) / (2.0 * h)
        assert by_q[:, :, k] == pytest.approx(slope, abs=1e-5 * np.abs(by_q).max())


def test_without_masses_there_are_no_equations(machine: Machine):
    """A machine whose masses are not known is refused."""
    for build in (equations_function, linearised_function):
        with pytest.raises(ValueError, match="without masses"):
            build(replace(machine, masses=None))
