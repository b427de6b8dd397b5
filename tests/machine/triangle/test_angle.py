"""The dependent angle ry: both ways of finding it, its branches and its limits."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.arrays import BoolArray, FloatArray
from pipeline.machine import MODES, InverseSolution, Machine, inverse_kinematics, statics_matrix
from pipeline.machine.geometry import cart_joints, platform_arms, rotation
from pipeline.machine.kinematics import closure_residual
from pipeline.machine.triangle import dependent_angle, on_axis, third_discriminant
from pipeline.machine.triangle.search import root_search

seeds = st.integers(0, 2**32 - 1)
off_axis_kinds = st.sampled_from(["off axis", "general"])

LLL = 0


def moved_off_axis(machine: Machine, x_m: float, z_m: float) -> Machine:
    """Move a_3a away from the platform's y axis."""
    points = machine.platform_points_m.copy()
    points[3, [0, 2]] += x_m, z_m
    return replace(machine, platform_points_m=points)


def with_length_of_3c(machine: Machine, length_m: float) -> Machine:
    """Give link 3c another length: the triangle is no longer right-angled."""
    lengths = machine.lengths_m.copy()
    lengths[5] = length_m
    return replace(machine, lengths_m=lengths)


def triangle_miss(
    machine: Machine, controlled: FloatArray, sign: float, ry: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """By how much link 3c misses its length for angles ry (m,), and the branch there; NaN out of arm 3's reach.

    Written from the closures alone: cart 3 is put where link 3a has its length, in the given working mode.
    """
    x, y, z, rx, rz = controlled
    pose = np.stack(np.broadcast_arrays(x, y, z, rx, ry, rz), axis=-1)
    joints = pose[:, :3] + platform_arms(machine, pose)[:, 3]
    across = joints[:, 1:] - machine.rails_m[2] - machine.cart_offsets_m[3, 1:]
    with np.errstate(invalid="ignore"):
        along = np.sqrt(machine.lengths_m[3] ** 2 - np.sum(across**2, axis=1))
    cart = joints[:, 0] - machine.cart_offsets_m[3, 0] + sign * along
    carts = np.column_stack([cart, cart, cart])
    q = np.column_stack([carts, np.ones((len(ry), 2))])
    miss = closure_residual(machine, pose, q)[:, 5]
    R = rotation(pose[:, 3], pose[:, 4], pose[:, 5])
    side = R @ (machine.platform_points_m[5] - machine.platform_points_m[3])
    link_3c = pose[:, :3] + platform_arms(machine, pose)[:, 5] - cart_joints(machine, carts)[:, 5]
    return miss, np.sum(R[:, :, 1] * np.cross(side, link_3c), axis=1)


def test_agrees_with_the_reference(machine: Machine, reference):
    """Ry is that of the reference to 1e-9."""
    signs = np.where(reference.modes % 2, 1.0, -1.0)
    ry = dependent_angle(machine, reference.controlled, signs)
    np.testing.assert_allclose(ry, reference.column("ry_rad"), atol=1e-9)


@given(seed=seeds)
@settings(max_examples=15)
def test_root_search_agrees_with_the_closed_form(draw_machine: Callable, draw_controlled: Callable, seed: int):
    """On the axis both find the same angle, or both none."""
    machine = draw_machine(seed, "on axis")
    controlled, modes = draw_controlled(seed, 100)
    signs = np.where(modes % 2, 1.0, -1.0)
    assert on_axis(machine)
    searched = root_search(machine, controlled, signs)
    np.testing.assert_allclose(searched, dependent_angle(machine, controlled, signs), atol=1e-9)


@pytest.mark.parametrize("offset_m", [1e-12, 1e-9])
def test_a_tiny_offset_changes_next_to_nothing(machine: Machine, reference, offset_m: float):
    """The root search takes over continuously where a_3a leaves the axis."""
    nearly = moved_off_axis(machine, offset_m, -offset_m)
    assert not on_axis(nearly)
    signs = np.where(reference.modes % 2, 1.0, -1.0)
    ry = dependent_angle(nearly, reference.controlled, signs)
    np.testing.assert_allclose(ry, reference.column("ry_rad"), atol=1e-7)


@given(seed=seeds, kind=off_axis_kinds)
@settings(max_examples=10)
def test_every_angle_closes_the_triangle_on_its_branch(
    draw_machine: Callable, draw_controlled: Callable, seed: int, kind: str
):
    """Found angles satisfy the closure of link 3c and have the machine's sign of y . (R w x u_3c)."""
    machine = draw_machine(seed, kind)
    controlled, modes = draw_controlled(seed, 100)
    signs = np.where(modes % 2, 1.0, -1.0)
    found = dependent_angle(machine, controlled, signs)
    for row in np.flatnonzero(np.isfinite(found)):
        miss, branch = triangle_miss(machine, controlled[row], signs[row], found[row : row + 1])
        assert abs(miss[0]) < 1e-12
        assert np.sign(branch[0]) == machine.triangle_sign
        assert -np.pi < found[row] <= np.pi


def scan(machine: Machine, controlled: FloatArray, sign: float, samples: int = 2000) -> tuple[FloatArray, BoolArray]:
    """Find solutions on the machine's branch by brute force, and which angles arm 3 does not reach."""
    grid = np.linspace(-np.pi, np.pi, samples + 1)
    miss, branch = triangle_miss(machine, controlled, sign, grid)
    with np.errstate(invalid="ignore"):
        crossing = (miss[:-1] * miss[1:] < 0.0) & (branch[:-1] * machine.triangle_sign > 0.0)
    return grid[:-1][crossing], np.isnan(miss)


@pytest.mark.parametrize(("kind", "seed"), [("on axis", 1), ("off axis", 2), ("off axis", 3), ("general", 4)])
def test_no_angle_is_overlooked(draw_machine: Callable, draw_controlled: Callable, kind: str, seed: int):
    """A dense scan of the closure finds solutions on the branch just where an angle was found, and there the same."""
    machine = draw_machine(seed, kind)
    controlled, modes = draw_controlled(seed, 80)
    signs = np.where(modes % 2, 1.0, -1.0)
    found = dependent_angle(machine, controlled, signs)
    compared = 0
    for row in range(len(controlled)):
        roots, _ = scan(machine, controlled[row], signs[row])
        if len(roots) == 0:
            # A scan may step over two neighbouring roots or one beside the limit of reach: the closure decides.
            value, _ = triangle_miss(machine, controlled[row], signs[row], found[row : row + 1])
            assert np.isnan(found[row]) or abs(value[0]) < 1e-12
        else:
            assert np.abs(roots - found[row]).min() < 4e-3
            compared += 1
    assert compared > 25


def test_a_root_beside_the_limit_of_reach_is_found(machine: Machine):
    """Where link 3a almost lies across its rail, the interval of angles within reach is short, and still searched."""
    far = moved_off_axis(machine, -0.2, 0.1)
    rng = np.random.default_rng(7)
    controlled = np.column_stack(
        [np.zeros(200), rng.uniform(-0.4, 1.2, 200), rng.uniform(0.9, 1.4, 200), rng.uniform(-0.3, 0.3, (200, 2))]
    )
    signs = rng.choice([-1.0, 1.0], 200)
    found = dependent_angle(far, controlled, signs)
    beside = 0
    for row in range(len(controlled)):
        roots, beyond = scan(far, controlled[row], signs[row])
        if len(roots) == 1:
            assert abs(roots[0] - found[row]) < 4e-3
            near = int((roots[0] + np.pi) / (2.0 * np.pi) * 2000)
            beside += beyond[max(near - 25, 0) : near + 25].any()
    assert beside > 3


def test_an_angle_of_exactly_zero_is_found(machine: Machine):
    """A root at ry = 0, where symmetric machines have theirs, does not fall between the samples of the search."""
    # With w along z and all of arm 3 in the plane x-y of the platform, u_3a . R w vanishes at ry = 0.
    points = machine.platform_points_m.copy()
    points[3] = [0.02, 0.1, 0.0]
    points[5] = [0.02, 0.1, 0.13]
    rails = machine.rails_m.copy()
    rails[2] = [0.0, 0.5]
    for sign in (-1.0, 1.0):
        symmetric = replace(machine, platform_points_m=points, rails_m=rails, triangle_sign=sign)
        controlled = np.array([[1.0, 0.4, 0.5, 0.0, 0.0], [1.0, 0.4, 0.5, 0.0, 0.0]])
        ry = dependent_angle(symmetric, controlled, np.array([-1.0, 1.0]))
        assert np.isfinite(ry).all()
        assert np.abs(ry).min() < 1e-12


def test_the_two_branches_are_the_two_solutions(machine: Machine, reference):
    """The other sign of the triangle gives the other solution: both close it, on opposite branches."""
    other = replace(machine, triangle_sign=1.0)
    signs = np.where(reference.modes % 2, 1.0, -1.0)
    first = dependent_angle(machine, reference.controlled, signs)
    second = dependent_angle(other, reference.controlled, signs)
    assert np.abs(first - second).min() > 1e-3
    for row in range(len(first)):
        both = np.array([first[row], second[row]])
        miss, branch = triangle_miss(machine, reference.controlled[row], signs[row], both)
        np.testing.assert_allclose(miss, 0.0, atol=1e-12)
        np.testing.assert_array_equal(np.sign(branch), [-1.0, 1.0])


@pytest.mark.parametrize("offset_m", [0.0, 0.01])
def test_no_angle_out_of_arm_3s_reach(machine: Machine, offset_m: float):
    """Where link 3a is too short there is no ry, in either mode; arm 3's discriminant says so."""
    controlled = np.array([[1.0, 0.3, 1.6, 0.0, 0.0]] * 2)
    ry = dependent_angle(moved_off_axis(machine, offset_m, 0.0), controlled, np.array([-1.0, 1.0]))
    assert np.isnan(ry).all()
    assert (third_discriminant(machine, controlled, np.zeros(2)) < 0.0).all()


@pytest.mark.parametrize("offset_m", [0.0, 1e-6])
def test_no_angle_where_the_triangle_cannot_close(machine: Machine, offset_m: float):
    """With 3c so long that 3a must lean away from the side, there is no ry although arm 3 reaches."""
    leaning = moved_off_axis(with_length_of_3c(machine, 1.36), offset_m, 0.0)
    controlled = np.array([[1.0, 0.6, 0.9, 0.2, -0.1]])
    assert third_discriminant(leaning, controlled, np.zeros(1))[0] > 0.0
    assert np.isnan(dependent_angle(leaning, controlled, np.array([-1.0]))).all()
    solution = inverse_kinematics(leaning, controlled, np.array([LLL]))
    assert not solution.reachable[0]


def test_no_poses_no_angles(machine: Machine):
    """Empty input gives empty output, on the axis and off it."""
    for offset_m in (0.0, 0.01):
        assert dependent_angle(moved_off_axis(machine, offset_m, 0.0), np.empty((0, 5)), np.empty(0)).shape == (0,)


def test_both_modes_share_the_angle_at_the_serial_singularity(machine: Machine):
    """With sign 0 link 3a stands across its rail: the two modes' angles meet there as the square root of D_3."""
    y = 0.3
    top = np.sqrt(1.25**2 - (y + 0.1) ** 2)
    controlled = np.array([[1.0, y, top, 0.0, 0.0]])
    at_gate = dependent_angle(machine, controlled, np.array([0.0]))
    below = controlled - np.array([0, 0, 1e-10, 0, 0])
    for sign in (-1.0, 1.0):
        np.testing.assert_allclose(dependent_angle(machine, below, np.array([sign])), at_gate, atol=1e-4)


def test_two_branches_meet_where_the_triangle_folds(machine: Machine):
    """At |C| = hypot(A, B) the branches meet, their gap closing like a square root; off a right angle det H stays.

    So the fold is a singularity of the inverse kinematics, and of Type II only where link 3a lies along y.
    """
    machines = [replace(with_length_of_3c(machine, 1.36), triangle_sign=sign) for sign in (-1.0, 1.0)]

    def both(y: float) -> list[InverseSolution]:
        controlled = np.array([[1.0, y, 0.9, 0.2, -0.1]])
        return [inverse_kinematics(one, controlled, np.array([LLL])) for one in machines]

    closed, folded = 0.3, 0.6
    while closed < (middle := (closed + folded) / 2.0) < folded:
        closed, folded = (closed, middle) if np.isnan(both(middle)[0].pose).any() else (middle, folded)
    gaps = []
    for distance in (1e-4, 1e-6, 1e-8):
        first, second = both(closed - distance)
        gaps.append(abs(first.pose[0, 4] - second.pose[0, 4]))
        determinant = np.linalg.det(statics_matrix(machine, first.pose[0], np.array([0.3, 0.4, first.q_m[0, 2]])))
        assert abs(determinant) > 1e-4
    np.testing.assert_allclose(np.divide(gaps[:-1], gaps[1:]), 10.0, rtol=0.02)


def test_untilted_fold_of_the_right_angled_triangle_is_a_type_ii_singularity(machine: Machine):
    """Link 3a along the platform's y axis makes 3a and 3b one line when there is no tilt: det H = 0, whatever ry."""
    for ry in (-1.0, 0.0, 0.7, 2.0):
        pose = np.array([1.0, 1.25 - 0.1, 0.0, 0.0, ry, 0.0])
        H = statics_matrix(machine, pose, np.array([0.3, 0.4, 1.0]))
        np.testing.assert_allclose(H[:, 3], H[:, 4], atol=1e-15)
        assert abs(np.linalg.det(H)) < 1e-16


def test_inverse_kinematics_without_a_triangle_solution_is_unreachable(machine: Machine):
    """Where no ry exists nothing is reachable, in any mode, and arm 3's discriminant is still known."""
    controlled = np.array([[1.0, 0.3, 1.6, 0.1, 0.1]] * len(MODES))
    solution = inverse_kinematics(machine, controlled, np.arange(len(MODES)))
    assert not solution.reachable.any()
    assert np.isnan(solution.q_m).all()
    assert (solution.discriminants_m2[:, 2] < 0.0).all()
    assert np.isnan(solution.discriminants_m2[:, :2]).all()
