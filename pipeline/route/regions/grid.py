"""The grid of stage one: its axes and its points."""

import math

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import AxisConfig, Config
from pipeline.route.metric import ROUNDING

COUNTABLE = 10**12
"""Axes of more steps count as this long: nothing holds them anyway."""


def grid_points(config: Config) -> FloatArray:
    """List all controlled poses of the grid, x zero, within the tilt limits of the task. Shape (n, 5)."""
    y, z, rx, rz = grid_axes(config)
    mesh = np.meshgrid(y, z, rx, rz, indexing="ij")
    return np.column_stack([np.zeros(mesh[0].size), *(axis.ravel() for axis in mesh)])


def points_at(config: Config, numbers: IntArray) -> FloatArray:
    """Give the points of these numbers (k,) in the list of all, without listing the others. Shape (k, 5)."""
    axes = grid_axes(config)
    indices = np.unravel_index(numbers, [len(axis) for axis in axes])
    return np.column_stack([np.zeros(len(numbers)), *(axis[i] for axis, i in zip(axes, indices, strict=True))])


def grid_axes(config: Config) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Compute the grid values of y, z (metres), rx, rz (radians); a locked axis has only zero."""
    grid = config.route.grid
    y, z, rx, rz = grid_shape(config)
    tilts = [
        np.deg2rad(step * np.arange(-(count // 2), count // 2 + 1, dtype=float))
        for step, count in ((grid.rx_step_deg, rx), (grid.rz_step_deg, rz))
    ]
    return _values(grid.y_m, y), _values(grid.z_m, z), tilts[0], tilts[1]


def grid_shape(config: Config) -> tuple[int, int, int, int]:
    """Count the grid values of y, z, rx, rz without listing them; their product is the number of points.

    An axis of more than `COUNTABLE` steps has at least as many values as are counted.
    """
    grid, task = config.route.grid, config.task
    tilts = [
        1 + 2 * (0 if axis in task.locked_axes else _steps(task.tilt_max_deg, step))
        for axis, step in (("rx", grid.rx_step_deg), ("rz", grid.rz_step_deg))
    ]
    sides = [1 + _steps(axis.max - axis.min, axis.step) for axis in (grid.y_m, grid.z_m)]
    return sides[0], sides[1], tilts[0], tilts[1]


def _steps(length: float, step: float) -> int:
    # The quotient of a tiny step is infinite.
    return math.floor(min(length / step, COUNTABLE) + ROUNDING)


def _values(axis: AxisConfig, count: int) -> FloatArray:
    return axis.min + axis.step * np.arange(count, dtype=float)
