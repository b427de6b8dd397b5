"""Paths to be timed: a curve through reachable poses, and lines whose fastest timing is known."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.interpolate import BSpline, CubicSpline, make_interp_spline

from pipeline.machine import Machine, inverse_kinematics
from pipeline.refine.result import Path

POSES = np.array(
    [
        [1.02, 0.30, 0.90, 0.00, 0.00],
        [1.30, 0.45, 0.75, 0.15, -0.10],
        [1.10, 0.60, 0.80, -0.10, 0.20],
        [0.80, 0.35, 1.00, 0.10, 0.10],
        [1.00, 0.25, 0.80, 0.00, -0.15],
        [1.02, 0.30, 0.90, 0.00, 0.00],
    ]
)

LineMaker = Callable[..., Path]


@pytest.fixture(scope="session")
def path(machine: Machine) -> Path:
    """Splines of 30 coefficients through reachable poses, about two metres of travel for two of the carts."""
    s = np.linspace(0.0, 1.0, 30)
    curve = CubicSpline(np.linspace(0.0, 1.0, len(POSES)), POSES)
    solution = inverse_kinematics(machine, curve(s), np.zeros(len(s), dtype=np.int64))
    assert solution.reachable.all()
    return Path(machine, make_interp_spline(s, solution.q_m, k=5), s, solution.pose)


@pytest.fixture(scope="session")
def line(machine: Machine) -> LineMaker:
    """Make paths on which all carts travel together along X, s bent by f(s), and the pose moves with them."""

    def make(travel_m: float, f: Callable[[np.ndarray], np.ndarray] = lambda s: s, points: int = 12) -> Path:
        s = np.linspace(0.0, 1.0, points)
        solution = inverse_kinematics(machine, POSES[:1], np.zeros(1, dtype=np.int64))
        along = (f(s) - f(s[:1])) / (f(s[-1:]) - f(s[:1])) * travel_m
        q = solution.q_m + along[:, None] * np.array([1.0, 1.0, 1.0, 0.0, 0.0])
        pose = solution.pose + along[:, None] * np.eye(6)[0]
        return Path(machine, make_interp_spline(s, q, k=5), s, pose)

    return make


def reverse(path: Path) -> Path:
    """Drive the same curve the other way round."""
    spline = BSpline(1.0 - path.spline.t[::-1], path.spline.c[::-1], path.spline.k)
    return Path(path.machine, spline, 1.0 - path.node_s[::-1], path.node_pose[::-1])


@pytest.fixture(scope="session")
def reversed_path(path: Path) -> Path:
    """Return the curve of `path`, driven the other way round."""
    return reverse(path)
