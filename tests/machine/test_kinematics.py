"""Inverse kinematics in all modes, serial singularities, and forward kinematics from nearby poses."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from pipeline.arrays import FloatArray
from pipeline.errors import ForwardKinematicsError
from pipeline.machine import InverseSolution, Machine, forward_kinematics, inverse_kinematics, statics_matrix
from pipeline.machine.geometry import MODE_SIGNS, MODES, PRIMARY, link_vectors, rotation
from pipeline.machine.kinematics import (
    closure_jacobian,
    closure_residual,
    discriminants,
    newton,
    pose_jacobian,
)
from pipeline.machine.pose import full_pose

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(["on axis", "off axis", "general"])

GATES = [
    pytest.param(1, "RRR", [1.0, 0.43, 0.59, -0.02, 0.16], id="arm 1"),
    pytest.param(2, "RLL", [1.0, 0.17, 0.57, 0.15, 0.13], id="arm 2"),
    pytest.param(3, "RLR", [1.0, 0.10, 1.21, 0.20, 0.09], id="arm 3"),
]
"""An arm, a working mode and a controlled pose near that arm's serial singularity."""


def test_a_known_angle_and_discriminants_of_a_pose_are_those_of_the_whole_solution(machine: Machine, reference):
    """What a search takes apart to be fast is what inverse kinematics does at once."""
    whole = inverse_kinematics(machine, reference.controlled, reference.modes)
    known = inverse_kinematics(machine, reference.controlled, reference.modes, ry_rad=whole.pose[:, 4])
    np.testing.assert_array_equal(known.q_m, whole.q_m)
    np.testing.assert_array_equal(full_pose(reference.controlled, whole.pose[:, 4]), whole.pose)
    np.testing.assert_array_equal(discriminants(machine, whole.pose), whole.discriminants_m2)


def at_gate(machine: Machine, arm: int, mode: str, near: list[float]) -> FloatArray:
    """Move a controlled pose along z to where D of an arm is zero."""
    controlled = np.array(near)

    def discriminant(z: float) -> float:
        there = np.where(np.arange(5) == 2, z, controlled)
        return float(inverse_kinematics(machine, there[None], [MODES.index(mode)]).discriminants_m2[0, arm - 1])

    controlled[2] = brentq(discriminant, near[2] - 0.05, near[2] + 0.05, xtol=1e-15)
    return controlled


def other_mode(mode: str, arm: int) -> str:
    """Change the working mode of one arm."""
    return "".join("LR"["RL".index(letter)] if k == arm - 1 else letter for k, letter in enumerate(mode))


def test_agrees_with_the_reference(machine: Machine, reference, reference_solution: InverseSolution):
    """Ry, carts and telescopes are those of the reference to 1e-9, in all eight modes."""
    assert reference_solution.reachable.all()
    np.testing.assert_allclose(reference_solution.pose[:, 4], reference.column("ry_rad"), atol=1e-9)
    np.testing.assert_allclose(reference_solution.q_m[:, :3], reference.column("carts_m"), atol=1e-9)
    np.testing.assert_allclose(reference_solution.q_m[:, 3:], reference.column("telescopes_m"), atol=1e-9)
    np.testing.assert_array_equal(reference_solution.pose[:, [0, 1, 2, 3, 5]], reference.controlled)


@given(seed=seeds, kind=kinds)
@settings(max_examples=30)
def test_solutions_close_every_link(draw_machine: Callable, draw_poses: Callable, seed: int, kind: str):
    """For any machine all six links have their lengths, and every cart is on the side its mode says."""
    machine = draw_machine(seed, kind)
    sample = draw_poses(machine, seed, kappa_max=np.inf)
    np.testing.assert_allclose(closure_residual(machine, sample.pose, sample.q_m), 0.0, atol=1e-12)
    from_cart = link_vectors(machine, sample.pose, sample.q_m[:, :3])[:, PRIMARY, 0]
    assert (from_cart * MODE_SIGNS[sample.modes] <= 0.0).all()


@given(seed=seeds, kind=kinds)
@settings(max_examples=30)
def test_forward_kinematics_inverts_inverse_kinematics(
    draw_machine: Callable, draw_poses: Callable, seed: int, kind: str
):
    """FK(IK(pose)) = pose for random machines, poses and modes, from a guess some millimetres away."""
    machine = draw_machine(seed, kind)
    sample = draw_poses(machine, seed, kappa_max=60.0)
    guess = sample.pose + np.random.default_rng(seed).uniform(-2e-3, 2e-3, sample.pose.shape)
    pose = forward_kinematics(machine, sample.q_m, guess)
    np.testing.assert_allclose(pose, sample.pose, atol=1e-9)
    np.testing.assert_allclose(closure_residual(machine, pose, sample.q_m), 0.0, atol=1e-11)


@given(seed=seeds, kind=kinds)
@settings(max_examples=20)
def test_closure_jacobian_is_the_derivative_of_the_residual(
    draw_machine: Callable, draw_poses: Callable, seed: int, kind: str
):
    """Central differences agree, at poses that close and at poses that do not."""
    machine = draw_machine(seed, kind)
    sample = draw_poses(machine, seed)
    q = sample.q_m + 0.01
    step = 1e-6 * np.eye(6)
    differences = [
        (closure_residual(machine, sample.pose + h, q) - closure_residual(machine, sample.pose - h, q)) / 2e-6
        for h in step
    ]
    np.testing.assert_allclose(closure_jacobian(machine, sample.pose, q), np.stack(differences, axis=-1), atol=2e-9)


def test_rows_of_the_statics_matrix_are_those_of_the_closure(machine: Machine, reference_solution: InverseSolution):
    """H' and the closure Jacobian differ by the map from angle rates to angular velocity, of determinant cos(rz)."""
    pose, q = reference_solution.pose, reference_solution.q_m
    J, H = closure_jacobian(machine, pose, q), statics_matrix(machine, pose, q[:, :3])
    np.testing.assert_allclose(J[:, :, :3], np.swapaxes(H[:, :3], 1, 2), atol=1e-15)
    for row in range(len(pose)):
        # Angular velocity per angle, from R(angle + h) R(angle - h)', independent of any axis convention.
        axes = []
        for h in 1e-6 * np.eye(3):
            spin = (rotation(*(pose[row, 3:] + h)) @ rotation(*(pose[row, 3:] - h)).T) / 2e-6
            axes.append([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]])
        E = np.array(axes).T / 2.0
        np.testing.assert_allclose(J[row, :, 3:], H[row, 3:].T @ E, atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(J), np.linalg.det(H) * np.cos(pose[:, 5]), rtol=1e-9)


@pytest.mark.parametrize(("arm", "mode", "near"), GATES)
def test_modes_meet_at_a_serial_singularity(machine: Machine, arm: int, mode: str, near: list[float]):
    """With the gate named, both modes of its arm have the same pose and actuators, link square to the rail."""
    controlled = at_gate(machine, arm, mode, near)
    modes = np.array([MODES.index(mode), MODES.index(other_mode(mode, arm))])
    solution = inverse_kinematics(machine, np.tile(controlled, (2, 1)), modes, np.array([arm, arm]))
    assert solution.reachable.all()
    np.testing.assert_array_equal(solution.q_m[0], solution.q_m[1])
    np.testing.assert_array_equal(solution.pose[0], solution.pose[1])
    np.testing.assert_array_equal(solution.discriminants_m2[:, arm - 1], 0.0)
    np.testing.assert_allclose(closure_residual(machine, solution.pose, solution.q_m), 0.0, atol=1e-12)
    along = link_vectors(machine, solution.pose, solution.q_m[:, :3])[:, PRIMARY[arm - 1], 0]
    np.testing.assert_allclose(along, 0.0, atol=1e-12)


@pytest.mark.parametrize(("arm", "mode", "near"), GATES)
def test_beyond_a_serial_singularity_nothing_is_reachable(machine: Machine, arm: int, mode: str, near: list[float]):
    """On one side of D = 0 both modes reach, on the other, however near, none does and D is negative."""
    controlled = at_gate(machine, arm, mode, near)
    outwards = 1.0 if arm == 3 else -1.0
    modes = [MODES.index(mode), MODES.index(other_mode(mode, arm))]
    for distance, reached in ((-1e-9, True), (1e-9, False)):
        there = controlled + np.array([0.0, 0.0, outwards * distance, 0.0, 0.0])
        solution = inverse_kinematics(machine, np.tile(there, (2, 1)), modes)
        assert (solution.reachable == reached).all()
        assert ((solution.discriminants_m2[:, arm - 1] > 0.0) == reached).all()
        assert np.isnan(solution.q_m[:, arm - 1]).any() != reached


def test_other_arms_of_a_pose_out_of_reach_are_still_known(machine: Machine):
    """Only the arm that does not reach has no cart; its neighbours keep theirs."""
    solution = inverse_kinematics(machine, np.array([[1.0, 1.0, 0.1, 0.0, 0.0]]), np.array([0]))
    assert not solution.reachable[0]
    assert (np.isnan(solution.q_m[0, :3]) == (solution.discriminants_m2[0] < 0.0)).all()
    assert np.isfinite(solution.q_m[0, 2])


def test_inverse_kinematics_of_no_poses(machine: Machine):
    """Empty input gives empty output."""
    solution = inverse_kinematics(machine, np.empty((0, 5)), np.empty(0, dtype=int))
    assert solution.pose.shape == (0, 6)
    assert solution.q_m.shape == (0, 5)


def test_forward_kinematics_tells_when_links_cannot_close(machine: Machine, reference_solution: InverseSolution):
    """Carts farther apart than the links allow raise an error with the row, the miss and what to do."""
    q = reference_solution.q_m[:3].copy()
    q[1, :3] = 0.0, 2.1, 0.0
    q[1, 3:] = 0.3
    with pytest.raises(ForwardKinematicsError, match="What to change") as caught:
        forward_kinematics(machine, q, reference_solution.pose[:3])
    assert caught.value.index == 1
    assert caught.value.residual_m > 1e-3
    assert "entry 1" in str(caught.value)


def test_forward_kinematics_tells_when_given_no_numbers(machine: Machine, reference_solution: InverseSolution):
    """A NaN among the actuators or in the guess is an error, never a pose."""
    q, pose = reference_solution.q_m[0], reference_solution.pose[0]
    for bad_q, bad_guess in ((np.where(np.arange(5) == 2, np.nan, q), pose), (q, pose * np.nan)):
        with pytest.raises(ForwardKinematicsError):
            forward_kinematics(machine, bad_q, bad_guess)


def test_forward_kinematics_from_a_joint_on_its_cart(machine: Machine, reference_solution: InverseSolution):
    """A guess that gives a link no length, and so no direction, is a singular closure and told as an error."""
    q = reference_solution.q_m[0].copy()
    cart_joint = np.array([q[0], *machine.rails_m[0]])
    guess = np.concatenate([cart_joint - machine.platform_points_m[0], np.zeros(3)])
    with pytest.raises(ForwardKinematicsError) as caught:
        forward_kinematics(machine, q, guess)
    assert caught.value.residual_m == np.inf


def test_one_guess_serves_many_actuator_positions(machine: Machine, reference_solution: InverseSolution):
    """A single pose is a guess for all rows, and a single row of actuators is enough."""
    q, pose = reference_solution.q_m[0], reference_solution.pose[0]
    nearby = q + np.linspace(0.0, 1e-3, 5)[:, None]
    poses = forward_kinematics(machine, nearby, pose)
    assert poses.shape == (5, 6)
    np.testing.assert_allclose(poses[0], pose, atol=1e-10)
    np.testing.assert_allclose(forward_kinematics(machine, q, pose), pose[None], atol=1e-12)


def test_newton_leaves_its_input_alone_and_reports_the_miss(machine: Machine, reference_solution: InverseSolution):
    """Solved rows come back closed, hopeless ones with the miss they ended at; guesses are not overwritten."""
    q = reference_solution.q_m[:2].copy()
    q[1, 3] += 2.0
    guess = reference_solution.pose[:2] + 1e-3
    kept = guess.copy()
    pose, miss = newton(machine, q, guess)
    np.testing.assert_array_equal(guess, kept)
    np.testing.assert_allclose(pose[0], reference_solution.pose[0], atol=1e-10)
    assert miss[0] < 1e-12
    assert miss[1] > 1e-3


def test_newton_converges_quadratically(machine: Machine, reference_solution: InverseSolution):
    """A tenth of the distance to the solution leaves a hundredth of the miss after one step."""
    q = reference_solution.q_m
    misses = []
    for distance in (1e-3, 1e-4):
        pose = reference_solution.pose + distance
        residual = closure_residual(machine, pose, q)
        pose = pose - np.linalg.solve(closure_jacobian(machine, pose, q), residual[..., None])[..., 0]
        misses.append(np.abs(closure_residual(machine, pose, q)).max(axis=1))
    np.testing.assert_allclose(np.log10(misses[0] / misses[1]), 2.0, atol=0.1)


def test_kinematics_of_a_machine_with_moved_rails(machine: Machine, reference, reference_solution: InverseSolution):
    """Moving frame and pose together along y and z changes no actuator."""
    shift = np.array([0.4, -0.7])
    moved = replace(machine, rails_m=machine.rails_m + shift)
    solution = inverse_kinematics(moved, reference.controlled + np.array([0, *shift, 0, 0]), reference.modes)
    np.testing.assert_allclose(solution.q_m, reference_solution.q_m, atol=1e-12)


@pytest.mark.parametrize("column", range(5))
def test_the_pose_follows_the_actuators(machine: Machine, reference_solution: InverseSolution, column: int):
    """Each column of the pose Jacobian against central differences of forward kinematics."""
    pose, q = reference_solution.pose, reference_solution.q_m
    step = np.where(np.arange(5) == column, 1e-6, 0.0)
    ahead, behind = (forward_kinematics(machine, q + sign * step, pose) for sign in (1.0, -1.0))
    expected = (ahead - behind) / 2e-6
    found = pose_jacobian(machine, pose, q)[:, :, column]
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())
