"""Mass matrix and velocity terms: against inverse dynamics, energies summed over bodies, and differences in time."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.machine import InverseSolution, Machine
from pipeline.machine.actuator_space import (
    actuator_rates,
    gravity_forces,
    mass_matrix,
    velocity_damping,
    velocity_forces,
)
from pipeline.machine.dynamics import inverse_dynamics
from pipeline.machine.geometry import cart_joints, link_vectors, rotation
from pipeline.machine.kinematics import pose_jacobian

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(["on axis", "off axis", "general"])


@given(seed=seeds, kind=kinds)
@settings(max_examples=8)
def test_the_mass_matrix_is_the_slope_of_inverse_dynamics_by_acceleration(draw_moving: Callable, seed: int, kind: str):
    """Column k of M is what accelerating actuator k by 1 m/s^2 takes from rest, more than holding."""
    moving = draw_moving(seed, kind)
    machine, pose, carts = moving.machine, moving.pose, moving.q_m[:, :3]
    by_q, rest = pose_jacobian(machine, pose, moving.q_m), np.zeros((len(pose), 6))
    M = mass_matrix(machine, moving.rates)
    held = inverse_dynamics(machine, machine.masses, pose, carts, rest, rest, np.zeros_like(carts)).drive_n
    assert gravity_forces(machine, moving.rates) == pytest.approx(held, rel=1e-9, abs=1e-8)
    for k in range(5):
        pushed = np.broadcast_to(np.eye(5)[k, :3], carts.shape)
        forces = inverse_dynamics(machine, machine.masses, pose, carts, rest, by_q[..., k], pushed).drive_n
        assert M[:, :, k] == pytest.approx(forces - held, rel=1e-9, abs=1e-9 * np.abs(M).max())


@given(seed=seeds, kind=kinds)
@settings(max_examples=8)
def test_the_mass_matrix_is_symmetric_and_positive_definite(draw_moving: Callable, seed: int, kind: str):
    """No direction weighs less than the lightest of what moves with it, and no drive less than its cart."""
    moving = draw_moving(seed, kind)
    M = mass_matrix(moving.machine, moving.rates)
    np.testing.assert_array_equal(M, np.swapaxes(M, 1, 2))
    assert np.linalg.eigvalsh(M).min() > 0.0
    assert (np.diagonal(M, axis1=1, axis2=2)[:, :3] > moving.machine.masses.cart_kg).all()


@given(seed=seeds, kind=kinds)
@settings(max_examples=8)
def test_kinetic_energy_is_that_of_all_bodies(draw_moving: Callable, seed: int, kind: str):
    """As qd' M qd / 2 it sums up over carts, half links and platform, each with its own velocity along the closures."""
    moving, h = draw_moving(seed, kind), 1e-5
    machine, masses = moving.machine, moving.machine.masses
    M = mass_matrix(machine, moving.rates)
    ends = [moving.at(sign * h * moving.qd_mps) for sign in (-1.0, 1.0)]
    joints = [cart_joints(machine, q[:, :3]) for _, q in ends]
    tips = [foot + link_vectors(machine, pose, q[:, :3]) for foot, (pose, q) in zip(joints, ends, strict=True)]
    rotations = [rotation(pose[:, 3], pose[:, 4], pose[:, 5]) for pose, _ in ends]
    centres = [pose[:, :3] + R @ masses.platform_centre_m for (pose, _), R in zip(ends, rotations, strict=True)]

    def squares(positions: list) -> np.ndarray:
        return (((positions[1] - positions[0]) / (2.0 * h)) ** 2).sum(axis=-1)

    spin = (rotations[1] - rotations[0]) / (2.0 * h) @ np.swapaxes(moving.rates.rotation, -1, -2)
    omega = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)
    omega = np.einsum("nji,nj->ni", moving.rates.rotation, omega)
    twice = masses.cart_kg * (moving.qd_mps[:, :3] ** 2).sum(axis=1)
    twice += (squares(joints) + squares(tips)) @ (masses.link_kg / 2.0)
    twice += masses.platform_kg * squares(centres) + masses.load_kg * squares([pose[:, :3] for pose, _ in ends])
    twice += np.einsum("ni,ij,nj->n", omega, masses.platform_inertia_kgm2, omega)
    found = np.einsum("ni,nij,nj->n", moving.qd_mps, M, moving.qd_mps)
    assert found == pytest.approx(twice, rel=1e-5)


@given(seed=seeds, kind=kinds)
@settings(max_examples=8)
def test_velocity_terms_are_those_of_inverse_dynamics(draw_moving: Callable, seed: int, kind: str):
    """With actuators at constant velocity, c + g is what inverse dynamics asks for, poses by differences in time."""
    moving, h = draw_moving(seed, kind), 1e-4
    machine, still = moving.machine, np.zeros((len(moving.pose), 3))

    def forces(step_s: float) -> np.ndarray:
        before, after = (moving.at(sign * step_s * moving.qd_mps)[0] for sign in (-1.0, 1.0))
        rate, acceleration = (after - before) / (2.0 * step_s), (after - 2.0 * moving.pose + before) / step_s**2
        return inverse_dynamics(
            machine, machine.masses, moving.pose, moving.q_m[:, :3], rate, acceleration, still
        ).drive_n

    # The error of differences is of second order, and large where the pose turns sharply: extrapolated to none.
    expected = (4.0 * forces(h) - forces(2.0 * h)) / 3.0
    found = velocity_forces(machine, moving.rates, moving.qd_mps) + gravity_forces(machine, moving.rates)
    assert found == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())


@given(seed=seeds, kind=kinds)
@settings(max_examples=8)
def test_damping_is_the_rate_of_the_mass_matrix(draw_moving: Callable, seed: int, kind: str):
    """The symmetric part of dc/dqd is dM/dt, so that c does the work of qd' dM/dt qd / 2: energy is kept."""
    moving, h = draw_moving(seed, kind), 1e-5
    machine, qd = moving.machine, moving.qd_mps
    damping = velocity_damping(machine, moving.rates, qd)
    moved = (moving.at(sign * h * qd) for sign in (-1.0, 1.0))
    before, after = (mass_matrix(machine, actuator_rates(machine, pose, q[:, :3])) for pose, q in moved)
    rate = (after - before) / (2.0 * h)
    assert (damping + np.swapaxes(damping, 1, 2)) / 2.0 == pytest.approx(rate, abs=1e-5 * np.abs(rate).max())
    c = velocity_forces(machine, moving.rates, qd)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", damping, qd), 2.0 * c, atol=1e-9 * np.abs(damping).max())
    power = np.einsum("ni,ni->n", qd, c)
    assert 2.0 * power == pytest.approx(np.einsum("ni,nij,nj->n", qd, rate, qd), abs=1e-5 * np.abs(rate).max())


def test_without_masses_there_is_no_inertia(machine: Machine, reference_solution: InverseSolution):
    """A machine whose masses are not known is refused."""
    sample, bare = reference_solution, replace(machine, masses=None)
    rates = actuator_rates(bare, sample.pose, sample.q_m[:, :3])
    with pytest.raises(ValueError, match="without masses"):
        mass_matrix(bare, rates)
    with pytest.raises(ValueError, match="without masses"):
        velocity_forces(bare, rates, sample.q_m)
