"""The grid of stage one: its axes and its points."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import AxisConfig, Config
from pipeline.route.metric import ROUNDING


def grid_points(config: Config) -> FloatArray:
    """List all controlled poses of the grid, x zero, within the tilt limits of the task. Shape (n, 5)."""
    y, z, rx, rz = grid_axes(config)
    mesh = np.meshgrid(y, z, rx, rz, indexing="ij")
    return np.column_stack([np.zeros(mesh[0].size), *(axis.ravel() for axis in mesh)])


def grid_axes(config: Config) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Compute the grid values of y, z (metres), rx, rz (radians); a locked axis has only zero."""
    grid, task = config.route.grid, config.task
    tilts = []
    for axis, step in (("rx", grid.rx_step_deg), ("rz", grid.rz_step_deg)):
        count = 0 if axis in task.locked_axes else int(np.floor(task.tilt_max_deg / step + ROUNDING))
        tilts.append(np.deg2rad(step * np.arange(-count, count + 1, dtype=float)))
    return _values(grid.y_m), _values(grid.z_m), tilts[0], tilts[1]


def _values(axis: AxisConfig) -> FloatArray:
    count = int(np.floor((axis.max - axis.min) / axis.step + ROUNDING)) + 1
    return axis.min + axis.step * np.arange(count, dtype=float)
