"""Stiffness by gravity: against differences of holding forces along the closures, and where it cannot be computed."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.machine import InverseSolution, Machine, statics_matrix
from pipeline.machine.actuator_space import actuator_rates, gravity_forces, gravity_stiffness
from pipeline.machine.dynamics import holding_forces

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(["on axis", "off axis", "general"])


@given(seed=seeds, kind=kinds)
@settings(max_examples=8)
def test_stiffness_is_the_slope_of_holding_forces_along_the_closures(draw_moving: Callable, seed: int, kind: str):
    """Column k is the change of all holding forces as actuator k is moved and the links stay closed."""
    moving, h = draw_moving(seed, kind), 1e-6
    machine = moving.machine
    K = gravity_stiffness(machine, moving.rates)
    for k in range(5):
        moved = (moving.at(sign * h * np.eye(5)[k]) for sign in (-1.0, 1.0))
        before, after = (
            holding_forces(machine, machine.masses, pose, statics_matrix(machine, pose, q[:, :3])).drive_n
            for pose, q in moved
        )
        assert K[:, :, k] == pytest.approx((after - before) / (2.0 * h), abs=1e-5 * np.abs(K).max())


@given(seed=seeds, kind=kinds)
@settings(max_examples=8)
def test_stiffness_grows_with_gravity_alone(draw_moving: Callable, seed: int, kind: str):
    """It is symmetric, linear in gravity, and does not depend on the characteristic length."""
    moving = draw_moving(seed, kind)
    machine, K = moving.machine, gravity_stiffness(moving.machine, moving.rates)
    np.testing.assert_array_equal(K, np.swapaxes(K, 1, 2))
    upside_down = replace(machine, masses=replace(machine.masses, gravity_mps2=-machine.masses.gravity_mps2))
    np.testing.assert_allclose(gravity_stiffness(upside_down, moving.rates), -K, rtol=1e-12)
    other = replace(machine, characteristic_length_m=2.0 * machine.characteristic_length_m)
    rates = actuator_rates(other, moving.pose, moving.q_m[:, :3])
    np.testing.assert_allclose(gravity_stiffness(other, rates), K, atol=1e-8 * np.abs(K).max())


def test_at_a_singular_pose_only_that_pose_is_nan(machine: Machine, reference_solution: InverseSolution):
    """Whatever H has to be solved for is NaN there, and as before at all other poses."""
    sample = reference_solution
    H = statics_matrix(machine, sample.pose, sample.q_m[:, :3])
    H[1] = 0.0
    rates = actuator_rates(machine, sample.pose, sample.q_m[:, :3], H)
    for found in (gravity_stiffness(machine, rates), gravity_forces(machine, rates)):
        singular = np.isnan(found).reshape(len(H), -1)
        assert singular[1].all()
        assert singular.any(axis=1).sum() == 1


def test_without_masses_there_is_no_stiffness(machine: Machine, reference_solution: InverseSolution):
    """A machine whose masses are not known is refused."""
    sample, bare = reference_solution, replace(machine, masses=None)
    rates = actuator_rates(bare, sample.pose, sample.q_m[:, :3])
    with pytest.raises(ValueError, match="without masses"):
        gravity_stiffness(bare, rates)
