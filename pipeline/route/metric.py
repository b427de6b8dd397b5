"""The metric of the route: controlled poses divided by the largest move per step.

In it a step of the route is at most one long in every coordinate, which makes the integral of kappa along a
path comparable to the sum (5) of a route.
"""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import RouteConfig
from pipeline.machine.pose import CONTROLLED

ROUNDING = 1e-9
"""Differences up to this count as rounding: absolute in steps, metres, radians and kappa, relative in sums of kappa."""


def step_sizes(config: RouteConfig) -> FloatArray:
    """Largest moves per step of x, y, z (metres), rx, rz (radians), (13)-(17). Shape (5,)."""
    grid = config.grid
    tilts = np.deg2rad([grid.rx_step_deg, grid.rz_step_deg])
    return np.array([config.x_step_m, grid.y_m.step, grid.z_m.step, *tilts])


def arc_length(poses: FloatArray, steps: FloatArray) -> FloatArray:
    """Length along a polyline of poses (n, 6) in steps, from zero at the first. Shape (n,)."""
    moves = np.diff(poses[:, CONTROLLED], axis=0) / steps
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(moves, axis=1))])
