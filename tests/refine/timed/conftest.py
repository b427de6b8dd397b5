"""Straight moves along X, driven smoothly."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.interpolate import BSpline

from pipeline.machine import Machine, inverse_kinematics
from pipeline.refine import Path
from pipeline.refine.timed.first_motion import Clock, fit_motion
from pipeline.refine.timed.hull import least_motion_s

TRAVEL_M = 0.4
START = np.array([[1.0, 0.3, 0.9, 0.0, 0.0]])


@pytest.fixture(scope="session")
def straight_motion(machine: Machine) -> Callable[[int], Path]:
    """Make motions of so many coefficients: all carts alike, no telescope, as fast as limits let them."""

    def make(coefficients: int) -> Path:
        solution = inverse_kinematics(machine, START, np.zeros(1, dtype=np.int64))
        part = np.linspace(0.0, 1.0, 12)
        q = solution.q_m + TRAVEL_M * part[:, None] * np.array([1.0, 1.0, 1.0, 0.0, 0.0])
        pose = solution.pose + TRAVEL_M * part[:, None] * np.eye(6)[0]
        path = Path(machine, BSpline(np.concatenate([[0.0], part, [1.0]]), q, 1), part, pose)
        even = np.linspace(0.0, 1.0, 101)
        spline = fit_motion(path, Clock(even, even**3 * (10.0 - 15.0 * even + 6.0 * even**2)), coefficients)
        tau = np.linspace(0.0, 1.0, 4 * coefficients + 1)
        x = (spline(tau)[:, :1] - spline(0.0)[0]) * np.eye(6)[0]
        return Path(machine, spline, tau, pose[0] + x, motion_s=least_motion_s(machine, spline))

    return make
