"""The coarse path with rounded corners."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from pipeline.compare.blend import blended
from pipeline.machine import Machine, inverse_kinematics
from pipeline.machine.kinematics import closure_residual, follow
from pipeline.refine.result import Path

S = np.linspace(0.0, 1.0, 20_001)
PER_MOVE = 20
SPACING_M = 4e-5
"""Of samples along the zigzag, which is shorter than 0.8 m."""


def zigzag(machine: Machine, sway_m: float = 0.04) -> Path:
    """Go through five poses by straight moves, in a parameter that is not their length."""
    controlled = np.tile([1.02, 0.3, 0.9, 0.0, 0.0], (5, 1))
    controlled[:, 1] += np.linspace(0.0, 0.2, 5)
    controlled[1::2, 2] -= sway_m
    solution = inverse_kinematics(machine, controlled, np.zeros(5, dtype=int))
    corners = np.array([0.0, 0.2, 0.5, 0.8, 1.0])
    spline = BSpline(np.concatenate([[0.0], corners, [1.0]]), solution.q_m, 1)
    node_s = np.interp(np.arange(4 * PER_MOVE + 1) / PER_MOVE, np.arange(5), corners)
    poses, _ = follow(machine, spline(node_s)[None], solution.pose[:1])
    return Path(machine, spline, node_s, poses[0])


def test_steps_that_stand_still_change_nothing(machine: Machine) -> None:
    """A route may wait at a step, at its end, too: its nodes stand still there, and are the same place."""
    plain = zigzag(machine)
    waiting = replace(
        plain,
        node_s=np.concatenate([plain.node_s[:9], np.repeat(plain.node_s[8], 4), plain.node_s[9:], [1.0] * 5]),
        node_pose=np.vstack(
            [
                plain.node_pose[:9],
                np.repeat(plain.node_pose[8:9], 4, axis=0),
                plain.node_pose[9:],
                np.repeat(plain.node_pose[-1:], 5, axis=0),
            ]
        ),
    )
    np.testing.assert_array_equal(blended(waiting).pose(S[::50]), blended(plain).pose(S[::50]))


def distances_to(path: Path, points: np.ndarray) -> np.ndarray:
    """Give how near a path comes to points (n, 5) in actuator space. Shape (n,)."""
    q = path.q(S)
    return np.array([np.linalg.norm(q - point, axis=1).min() for point in points])


@pytest.fixture(scope="module")
def coarse(machine: Machine) -> Path:
    """Give the zigzag."""
    return zigzag(machine)


def test_corners_are_passed_at_the_tolerance(coarse: Path) -> None:
    """Each corner within the path is missed by the tolerance, the ends are met."""
    misses = distances_to(blended(coarse, 0.001), coarse.spline.c)
    np.testing.assert_allclose(misses[1:-1], 0.001, rtol=1e-3)
    np.testing.assert_allclose(misses[[0, -1]], 0.0, atol=1e-12)


@given(tolerance_m=st.floats(1e-5, 0.1))
def test_no_more_than_the_tolerance(coarse: Path, tolerance_m: float) -> None:
    """Whatever is asked for: within the tolerance, and where moves are too short for it, nearer."""
    assert (distances_to(blended(coarse, tolerance_m), coarse.spline.c) <= tolerance_m + SPACING_M).all()


def test_straight_between_blends_at_even_speed(coarse: Path) -> None:
    """In the middle of a move the path is the move, and s is its length in actuator space."""
    path = blended(coarse, 0.001)
    ends = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(coarse.spline.c, axis=0), axis=1)))
    middles = (ends[1:] + ends[:-1]) / 2.0 / ends[-1]
    np.testing.assert_allclose(path.q(middles), (coarse.spline.c[1:] + coarse.spline.c[:-1]) / 2.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(path.q(middles, 1), axis=1), ends[-1], rtol=1e-9)
    np.testing.assert_allclose(path.q(middles, 2), 0.0, atol=1e-6)


def test_three_derivatives_are_continuous(coarse: Path) -> None:
    """From both sides of every knot the derivatives agree, as far as the next one changes them."""
    path = blended(coarse, 0.001)
    knots = np.unique(path.spline.t)[1:-1]
    step = 1e-9
    for order in (1, 2, 3):
        jump = np.abs(path.q(knots + step, order) - path.q(knots - step, order)).max()
        assert jump <= 4.0 * step * np.abs(path.q(S, order + 1)).max() + 1e-6


def test_a_straight_path_stays_as_it_is(machine: Machine) -> None:
    """Corners that are none are not rounded, only the parameter becomes even."""
    straight = zigzag(machine)
    q = straight.spline.c[0] + np.linspace(0.0, 1.0, 5)[:, None] * (straight.spline.c[1] - straight.spline.c[0])
    spline = BSpline(straight.spline.t, q, 1)
    poses, _ = follow(machine, spline(straight.node_s)[None], straight.node_pose[:1])
    path = blended(Path(machine, spline, straight.node_s, poses[0]))
    np.testing.assert_allclose(path.q(S), q[0] + S[:, None] * (q[-1] - q[0]), atol=1e-12)


def test_poses_close(machine: Machine, coarse: Path) -> None:
    """The poses are those of the new actuator positions, also at the nodes."""
    path = blended(coarse, 0.005)
    s = np.linspace(0.0, 1.0, 501)
    assert np.abs(closure_residual(machine, path.pose(s), path.q(s))).max() < 1e-10
    assert np.abs(closure_residual(machine, path.node_pose, path.q(path.node_s))).max() < 1e-10


@settings(max_examples=20)
@given(sway_m=st.floats(0.005, 0.1))
def test_the_spline_ends_where_the_path_does(machine: Machine, sway_m: float) -> None:
    """Whatever the length of the path: rounding must not put the last condition of the spline beyond its last knot."""
    path = zigzag(machine, sway_m)
    np.testing.assert_allclose(blended(path, 0.002).q(1.0), path.q(1.0), atol=1e-12)
