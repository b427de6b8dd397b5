"""Errors of the actuators as symbols: every pose of every error is within its box."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify.guess import guess_box
from pipeline.certify.recheck.arithmetic import inclusion as again
from pipeline.inclusion.closure import geometry, working_precision
from pipeline.inclusion.krawczyk import Inclusion, along, include
from pipeline.inclusion.pieces import pieces
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty, of_actuators
from pipeline.machine import Machine
from pipeline.machine.geometry import link_lengths, link_vectors
from pipeline.machine.kinematics import closure_jacobian, newton
from pipeline.machine.statics import statics_matrix
from pipeline.refine import Path
from tests.certify.audit import ROUNDING, cubic
from tests.certify.paths import START, pose_path
from tests.rails import off_x

_EPS = 2e-3
_CORNERS = np.array(list(itertools.product([-1.0, 1.0], repeat=5)))


def _prove(path: Path, uncertainty: Uncertainty, part: float = 1.0) -> Inclusion:
    """Prove a box over a part of the first piece."""
    piece = pieces(path.spline)[0]
    with working_precision(64):
        box = guess_box(path, piece.first, piece.first + part * (piece.last - piece.first))
        assert box is not None
        balls = geometry(path.machine)
        inclusion = include(balls, along(balls, piece, box), box, uncertainty)
    assert inclusion is not None
    return inclusion


def _image(inclusion: Inclusion) -> np.ndarray:
    return np.array([float(k.upper()) for k in inclusion.image])


def _gradient_corners(path: Path, s: np.ndarray) -> np.ndarray:
    """Give the corners along which |det H| changes fastest, up and down."""
    pose, q = path.pose(s), path.q(s)
    slopes = []
    for drive in np.eye(5):
        moved, _ = newton(path.machine, q + 1e-6 * drive, pose)
        carts = (q + 1e-6 * drive)[:, :3]
        slopes.append(np.abs(np.linalg.det(statics_matrix(path.machine, moved, carts))))
    signs = np.sign(np.array(slopes).T - np.abs(np.linalg.det(statics_matrix(path.machine, pose, q[:, :3])))[:, None])
    return np.concatenate([signs, -signs])


@pytest.mark.parametrize("weights", [np.ones(5), np.array([1.0, 1.0, 1.0, 0.2, 0.2]), np.eye(5)[3]])
def test_every_pose_of_every_error_is_within_its_box(machine: Machine, line: Path, weights: np.ndarray) -> None:
    """Some 4,000 poses: corners, those of the steepest det H, and random errors, all over the interval."""
    inclusion = _prove(line, of_actuators(weights)(_EPS))
    random, image = np.random.default_rng(1), _image(inclusion)
    s = np.linspace(inclusion.box.first, inclusion.box.last, 41)
    t = s - (inclusion.box.first + inclusion.box.last) / 2.0
    P = inclusion.following.matrix[0] + inclusion.following.matrix[1] * t[:, None, None]
    errors = [*(np.tile(corner, (41, 1)) for corner in _CORNERS), *np.split(_gradient_corners(line, s), 2)]
    errors += list(random.uniform(-1.0, 1.0, (60, 41, 5)))
    for error in errors:
        a = _EPS * weights * error
        start = cubic(inclusion.box, s) + np.einsum("nij,nj->ni", P, a)
        pose, miss = newton(machine, line.q(s) + a, start)
        assert (miss < ROUNDING).all()
        assert (np.abs(pose - start) <= image + ROUNDING).all()


def test_the_symbols_are_the_derivatives_of_the_pose(machine: Machine, line: Path) -> None:
    """P = -J^-1 df/dq, by finite differences."""
    inclusion = _prove(line, of_actuators(np.ones(5))(1e-4))
    s = np.array([(inclusion.box.first + inclusion.box.last) / 2.0])
    pose, q = line.pose(s), line.q(s)
    step = 1e-6
    found = [
        (newton(machine, q + step * drive, pose)[0] - newton(machine, q - step * drive, pose)[0])[0] / (2.0 * step)
        for drive in np.eye(5)
    ]
    np.testing.assert_allclose(inclusion.following.matrix[0], np.array(found).T, atol=1e-6)
    assert np.linalg.cond(closure_jacobian(machine, pose, q)[0]) < 1e6


def test_what_errors_add_is_of_second_order(line: Path) -> None:
    """Half the error adds a quarter; none adds nothing."""
    none, half, whole = (_image(_prove(line, of_actuators(np.ones(5))(eps), 0.02)) for eps in (0.0, 2e-4, 4e-4))
    np.testing.assert_array_equal(none, _image(_prove(line, CERTAIN, 0.02)))
    np.testing.assert_allclose(whole / half, 4.0, rtol=0.1)


def test_calibration_and_actuators_may_be_wrong_together(machine: Machine, line: Path) -> None:
    """The pose is within |C| E + |P| A + k of the cubic, and within the box about P a for links that are off."""
    eps, lengths = 5e-4, 2e-4
    inclusion = _prove(line, Uncertainty(lengths, 0.0, (eps,) * 5))
    random, image = np.random.default_rng(2), _image(inclusion)
    s = np.linspace(inclusion.box.first, inclusion.box.last, 41)
    t = s - (inclusion.box.first + inclusion.box.last) / 2.0
    P, C = (part[0] + part[1] * t[:, None, None] for part in (inclusion.following.matrix, inclusion.inverse))
    E = np.array([float(e.upper()) for e in inclusion.residual_change])
    for _ in range(40):
        wrong, a = random.choice([-lengths, lengths], 6), random.choice([-eps, eps], 5)
        start = cubic(inclusion.box, s) + np.einsum("nij,j->ni", P, a)
        off = replace(machine, lengths_m=machine.lengths_m + wrong)
        q = line.q(s) + a + np.concatenate([np.zeros(3), wrong[[2, 4]]])
        pose, miss = newton(off, q, start)
        assert (miss < ROUNDING).all()
        assert (np.abs(pose - start) <= np.abs(C) @ E + image + ROUNDING).all()


_ALL_WRONG = Uncertainty(2e-4, 5e-5, (4e-4, 1e-4, 3e-4, 2e-4, 0.0))


@pytest.mark.parametrize("uncertainty", [_ALL_WRONG, of_actuators(np.ones(5))(1e-3)])
def test_on_rails_off_x_no_machine_leaves_its_image(machine: Machine, uncertainty: Uncertainty) -> None:
    """Every coordinate, length and actuator wrong: about x - C e + P a, each with its own e; in either arithmetic."""
    for seed in range(3):
        skewed, random = off_x(machine, seed), np.random.default_rng(seed)
        path = pose_path(skewed, np.linspace(START, [1.05, 0.33, 0.88, 0.05, -0.02], 41), 0)
        inclusion = _prove(path, uncertainty, 0.1)
        found = again.include(skewed, again.build_boxes(skewed, path, (inclusion.box,)), uncertainty)
        assert found.proven.all()
        image = np.minimum(_image(inclusion), found.image[:, 0])
        for s in np.linspace(inclusion.box.first, inclusion.box.last, 60):
            t, q = s - (inclusion.box.first + inclusion.box.last) / 2.0, path.q(np.array([s]))
            P, C = (part[0] + part[1] * t for part in (inclusion.following.matrix, inclusion.inverse))
            wrong, telescopes = _wrong(skewed, uncertainty, random)
            a = random.choice([-1.0, 1.0], 5) * uncertainty.actuator_m
            x, there = cubic(inclusion.box, np.array([s])), q + a + telescopes
            start = x - (_residual(wrong, x, there) - _residual(skewed, x, q + a)) @ C.T + P @ a
            pose, miss = newton(wrong, there, start)
            assert (miss < ROUNDING).all()
            assert (np.abs(pose - start) <= image + ROUNDING).all()


def _wrong(machine: Machine, uncertainty: Uncertainty, random: np.random.Generator) -> tuple[Machine, np.ndarray]:
    """Give a machine with errors of their size everywhere, and those of its telescopes (5,)."""

    def off(values: np.ndarray, eps: float) -> np.ndarray:
        return np.asarray(values + eps * random.choice([-1.0, 1.0], values.shape))

    points, offsets, rails = (
        off(values, uncertainty.coordinate_m)
        for values in (machine.platform_points_m, machine.cart_offsets_m, machine.rails_m)
    )
    wrong = replace(
        machine,
        platform_points_m=points,
        cart_offsets_m=offsets,
        rails_m=rails,
        lengths_m=off(machine.lengths_m, uncertainty.length_m),
    )
    return wrong, np.append(np.zeros(3), off(np.zeros(2), uncertainty.length_m))


def _residual(machine: Machine, pose: np.ndarray, q_m: np.ndarray) -> np.ndarray:
    """Compute the closures f_l, (n, 6)."""
    vectors = link_vectors(machine, pose, q_m[:, :3])
    return np.asarray(((vectors**2).sum(axis=2) - link_lengths(machine, q_m[:, 3:]) ** 2) / 2.0)
