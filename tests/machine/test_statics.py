"""The statics matrix, kappa and the sign of det H."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.machine import (
    MODES,
    InverseSolution,
    Machine,
    condition_number,
    det_sign,
    inverse_kinematics,
    statics_matrix,
)
from pipeline.machine.geometry import platform_arms

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(["on axis", "off axis", "general"])


def mirrored(machine: Machine) -> Machine:
    """Reflect a machine in the plane x = 0: its triangle assembles the other way round."""
    flip = np.array([-1.0, 1.0, 1.0])
    return replace(
        machine,
        platform_points_m=machine.platform_points_m * flip,
        cart_offsets_m=machine.cart_offsets_m * flip,
        travel_m=-machine.travel_m[:, ::-1],
        triangle_sign=-machine.triangle_sign,
    )


def test_agrees_with_the_reference(machine: Machine, reference, reference_solution: InverseSolution):
    """H, kappa and the sign of det H are those of the reference to 1e-9."""
    H = statics_matrix(machine, reference_solution.pose, reference_solution.q_m[:, :3])
    np.testing.assert_allclose(H, reference.column("H"), atol=1e-9)
    np.testing.assert_allclose(condition_number(H), reference.column("kappa"), rtol=1e-9)
    np.testing.assert_array_equal(det_sign(H), reference.column("det_sign"))


def test_columns_are_unit_forces_with_their_moments(machine: Machine, reference_solution: InverseSolution):
    """Every column is a unit vector and its moment about the TCP, perpendicular to it."""
    H = statics_matrix(machine, reference_solution.pose, reference_solution.q_m[:, :3])
    force, moment = H[:, :3], H[:, 3:]
    np.testing.assert_allclose(np.sum(force**2, axis=1), 1.0, rtol=1e-14)
    np.testing.assert_allclose(np.sum(force * moment, axis=1), 0.0, atol=1e-15)
    arms = platform_arms(machine, reference_solution.pose)
    np.testing.assert_allclose(moment[7, :, 2], np.cross(arms[7, 2], force[7, :, 2]), atol=1e-15)


def test_link_forces_balance_a_load(machine: Machine, reference_solution: InverseSolution):
    """Summed link by link, the forces that solve H f = load do the work of the load on any small motion."""
    rng = np.random.default_rng(2)
    pose, carts = reference_solution.pose[3], reference_solution.q_m[3, :3]
    load, twist = rng.normal(size=6), rng.normal(size=6)
    H = statics_matrix(machine, pose, carts)
    forces = np.linalg.solve(H, load)
    # A joint's velocity under the twist (v, w) is v + w x A'; the link's force acts along u.
    velocity = twist[:3] + np.cross(twist[3:], platform_arms(machine, pose))
    power = np.sum(forces * np.sum(velocity * H[:3].T, axis=1))
    assert power == pytest.approx(load @ twist, rel=1e-10)


def test_kappa_is_the_ratio_of_extreme_singular_values():
    """Kappa agrees with numpy's condition number and is infinite, without a warning, for a singular matrix."""
    H = np.random.default_rng(0).normal(size=(5, 6, 6))
    np.testing.assert_allclose(condition_number(H), [np.linalg.cond(matrix) for matrix in H], rtol=1e-10)
    assert condition_number(np.zeros((6, 6)) + np.diag([1.0, 1, 1, 1, 1, 0])) == np.inf
    assert det_sign(np.diag([1.0, 1, 1, 1, 1, 0])) == 0.0
    assert det_sign(np.diag([1.0, 1, 1, 1, 1, -1])) == -1.0


@given(seed=seeds, shift=st.floats(-3.0, 3.0))
def test_moving_along_the_rails_changes_nothing(machine: Machine, draw_poses: Callable, seed: int, shift: float):
    """H, kappa and det H do not depend on x, and the carts move along with it."""
    sample = draw_poses(machine, seed, 60)
    moved = inverse_kinematics(machine, sample.controlled + np.array([shift, 0, 0, 0, 0]), sample.modes)
    np.testing.assert_allclose(moved.q_m - sample.q_m, np.array([[shift] * 3 + [0.0] * 2]) + 0 * sample.q_m, atol=1e-12)
    before = statics_matrix(machine, sample.pose, sample.q_m[:, :3])
    np.testing.assert_allclose(statics_matrix(machine, moved.pose, moved.q_m[:, :3]), before, atol=1e-11)


@given(seed=seeds, kind=kinds)
@settings(max_examples=40)
def test_mirror_images_have_opposite_determinants(
    draw_machine: Callable, draw_poses: Callable, draw_controlled: Callable, seed: int, kind: str
):
    """The mirror image (x, ry, rz negated, L and R swapped, triangle reversed) has the same kappa and det H negated."""
    machine = draw_machine(seed, kind)
    sample = draw_poses(machine, seed)
    flip = np.array([-1.0, 1, 1, 1, -1])
    image = inverse_kinematics(mirrored(machine), sample.controlled * flip, len(MODES) - 1 - sample.modes)
    np.testing.assert_allclose(image.pose, sample.pose * np.array([-1.0, 1, 1, 1, -1, -1]), atol=1e-10)
    np.testing.assert_allclose(image.q_m, sample.q_m * np.array([-1.0, -1, -1, 1, 1]), atol=1e-10)
    H = statics_matrix(machine, sample.pose, sample.q_m[:, :3])
    H_image = statics_matrix(mirrored(machine), image.pose, image.q_m[:, :3])
    np.testing.assert_allclose(np.linalg.det(H_image), -np.linalg.det(H), rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(condition_number(H_image), sample.kappa, rtol=1e-6)


@given(y=st.floats(-0.2, 0.8), z=st.floats(0.3, 1.3), mode=st.integers(0, 7))
def test_without_tilt_the_determinant_factors(machine: Machine, y: float, z: float, mode: int):
    """With rx = rz = 0, det H is a product: what keeps the tilts times what keeps x, y, z and ry.

    Both parallelograms are closed then, so 2b - 2a and 3b - 3a are pure moments b e_y x u; the rest is the
    4 x 4 matrix of forces and moments about y.
    """
    solution = inverse_kinematics(machine, np.array([[1.0, y, z, 0.0, 0.0]]), np.array([mode]))
    if not solution.reachable[0]:
        return
    H = statics_matrix(machine, solution.pose[0], solution.q_m[0, :3])
    u_2, u_3 = H[:3, 1], H[:3, 3]
    tilting = 0.28**2 * (u_2[0] * u_3[2] - u_2[2] * u_3[0])
    spatial = np.linalg.det(H[np.ix_([0, 1, 2, 4], [0, 1, 3, 5])])
    assert abs(np.linalg.det(H)) == pytest.approx(abs(tilting * spatial), rel=1e-6, abs=1e-12)


def test_untilted_reconfiguration_must_pass_a_singularity(machine: Machine):
    """The tilt factor of det H has opposite signs all left and all right, anywhere between the rails."""
    mesh = np.stack(np.meshgrid(np.linspace(0.0, 0.5, 6), np.linspace(0.6, 1.2, 7)), axis=-1).reshape(-1, 2)
    controlled = np.column_stack([np.ones(len(mesh)), mesh, np.zeros((len(mesh), 2))])
    factors = []
    for mode in (0, 7):
        solution = inverse_kinematics(machine, controlled, np.full(len(mesh), mode))
        H = statics_matrix(machine, solution.pose[solution.reachable], solution.q_m[solution.reachable, :3])
        factors.append(H[:, 0, 1] * H[:, 2, 3] - H[:, 2, 1] * H[:, 0, 3])
    assert len(factors[0]) > 20
    assert (factors[0] > 0.0).all()
    assert (factors[1] < 0.0).all()
