"""Curves of actuator positions followed continuously: through serial singularities, and no further than they go."""

import numpy as np
import pytest

from pipeline.arrays import FloatArray
from pipeline.machine import MODES, InverseSolution, Machine, condition_number, inverse_kinematics, statics_matrix
from pipeline.machine.geometry import PRIMARY, link_vectors
from pipeline.machine.kinematics import closure_residual, follow, newton

START = np.array([[1.02, 0.3, 0.9, 0.0, 0.0]])


@pytest.fixture(scope="module")
def start(machine: Machine) -> InverseSolution:
    """Place the machine at the reference task's start, LLL."""
    return inverse_kinematics(machine, START, np.array([0]))


def straight(start: FloatArray, move: list[float], samples: int) -> FloatArray:
    """Go along a straight line in actuator space. Shape (1, samples, 5)."""
    return (start + np.linspace(0.0, 1.0, samples)[:, None] * np.array(move))[None]


@pytest.mark.parametrize(
    ("arm", "mode", "near"),
    [
        (1, "RRR", [1.0, 0.43, 0.5904, -0.02, 0.16]),
        (2, "RLL", [1.0, 0.17, 0.5733, 0.15, 0.13]),
        (3, "RLR", [1.0, 0.10, 1.2152, 0.20, 0.09]),
    ],
)
def test_a_serial_singularity_is_driven_straight_through(machine: Machine, arm: int, mode: str, near: list[float]):
    """A cart that moves past its platform joint changes the working mode, and nothing else happens."""
    # The pose is the gate but for rounding; the cart is abreast of its joint half way.
    controlled = np.array([near])
    side = -1.0 if mode[arm - 1] == "R" else 1.0
    first = inverse_kinematics(machine, controlled, np.array([MODES.index(mode)]), np.array([arm]))
    move = np.where(np.arange(5) == arm - 1, 0.2 * side, 0.0)
    before, _ = newton(machine, first.q_m - 0.5 * move, first.pose)
    q = (first.q_m - 0.5 * move + np.linspace(0.0, 1.0, 101)[:, None] * move)[None]
    poses, misses = follow(machine, q, before)
    assert misses.max() < 1e-9
    along = link_vectors(machine, poses[0], q[0, :, :3])[:, PRIMARY[arm - 1], 0]
    assert np.sign(along[0]) == -np.sign(along[-1])
    assert np.count_nonzero(np.diff(np.sign(along))) == 1
    H = statics_matrix(machine, poses[0], q[0, :, :3])
    assert len(np.unique(np.sign(np.linalg.det(H)))) == 1
    assert condition_number(H).max() < 100.0
    # Both ends are poses of the inverse kinematics, one in each mode of the arm.
    for end, letter in ((0, mode[arm - 1]), (-1, "LR"["RL".index(mode[arm - 1])])):
        there = MODES.index(mode[: arm - 1] + letter + mode[arm:])
        solved = inverse_kinematics(machine, poses[:, end][:, [0, 1, 2, 3, 5]], np.array([there]))
        np.testing.assert_allclose(solved.q_m, q[:, end], atol=1e-8)


def test_followed_poses_close_all_links_and_hardly_depend_on_sampling(machine: Machine, start: InverseSolution):
    """Every pose is a solution, and the same one at four times the samples."""
    move = [0.3, -0.2, 0.1, 0.05, 0.02]
    coarse, misses = follow(machine, straight(start.q_m[0], move, 26), start.pose)
    fine, _ = follow(machine, straight(start.q_m[0], move, 101), start.pose)
    assert misses.max() < 1e-9
    np.testing.assert_allclose(coarse[0], fine[0, ::4], atol=1e-9)
    residual = closure_residual(machine, fine[0], straight(start.q_m[0], move, 101)[0])
    np.testing.assert_allclose(residual, 0.0, atol=1e-9)


@pytest.mark.parametrize("telescope", [[0.0, 0.0, 0.0, 0.6, 0.0], [0.0, 0.0, 0.0, 0.0, -0.6]])
def test_a_curve_is_lost_at_a_type_ii_singularity(machine: Machine, start: InverseSolution, telescope: list[float]):
    """Pulled until the closure folds, the curve ends there, at the same place for any sampling, with kappa high."""
    place = []
    for samples in (101, 1001):
        q = straight(start.q_m[0], telescope, samples)
        poses, misses = follow(machine, q, start.pose)
        found = np.isfinite(misses[0])
        last = np.count_nonzero(found) - 1
        assert 0 < last < samples - 1
        assert found[: last + 1].all()
        np.testing.assert_array_equal(poses[0, last:], np.tile(poses[0, last], (samples - last, 1)))
        H = statics_matrix(machine, poses[0, : last + 1], q[0, : last + 1, :3])
        assert (np.linalg.det(H) > 0.0).all()
        place.append(last / (samples - 1))
    assert condition_number(H)[-1] > 200.0
    assert place[0] <= place[1] <= place[0] + 1 / 100


def test_a_curve_is_lost_out_of_reach_and_the_others_go_on(machine: Machine, start: InverseSolution):
    """Of two curves followed together one ends where links cannot close, the other arrives."""
    tear = straight(start.q_m[0], [-1.5, 0.0, 1.5, 0.0, 0.0], 101)
    shift = straight(start.q_m[0], [0.5, 0.5, 0.5, 0.0, 0.0], 101)
    poses, misses = follow(machine, np.concatenate([tear, shift]), np.tile(start.pose, (2, 1)))
    assert np.isfinite(misses[0, 0])
    assert np.isinf(misses[0, -1])
    assert np.isfinite(poses).all()
    assert misses[1].max() < 1e-9
    np.testing.assert_allclose(poses[1, -1], start.pose[0] + np.array([0.5, 0, 0, 0, 0, 0]), atol=1e-9)


def test_another_assembly_is_not_the_same_curve(machine: Machine, start: InverseSolution):
    """A curve that begins elsewhere than its start pose is lost at once, even if some pose there closes all links."""
    q = straight(start.q_m[0] + np.array([0.3, 0.3, 0.3, 0.0, 0.0]), [0.0] * 5, 10)
    _, miss = newton(machine, q[0, :1], start.pose)
    assert miss[0] < 1e-9
    poses, misses = follow(machine, q, start.pose)
    assert np.isinf(misses).all()
    np.testing.assert_array_equal(poses[0], np.tile(start.pose, (10, 1)))


def test_no_jump_to_another_assembly_with_the_same_sign(machine: Machine):
    """Random straight lines, most of which leave the workspace: consecutive poses are never far from one another."""
    rng = np.random.default_rng(1)
    controlled = rng.uniform([1.0, -0.1, 0.4, -0.3, -0.3], [1.0, 0.8, 1.2, 0.3, 0.3], (150, 5))
    solution = inverse_kinematics(machine, controlled, rng.integers(0, 8, 150))
    rows = np.flatnonzero(solution.reachable)
    direction = rng.normal(size=(len(rows), 5))
    direction *= 0.5 / np.linalg.norm(direction, axis=1, keepdims=True)
    q = solution.q_m[rows, None] + np.linspace(0.0, 1.0, 101)[:, None] * direction[:, None]
    poses, misses = follow(machine, q, solution.pose[rows])
    lost = np.isinf(misses[:, -1])
    assert 0 < np.count_nonzero(lost) < len(rows)
    change = np.abs(np.diff(poses, n=2, axis=1)).max(axis=2)
    followed = np.isfinite(misses[:, 2:])
    assert change[followed].max() <= 0.1


def test_nothing_to_follow(machine: Machine):
    """No curves give no poses."""
    poses, misses = follow(machine, np.empty((0, 4, 5)), np.empty((0, 6)))
    assert poses.shape == (0, 4, 6)
    assert misses.shape == (0, 4)
