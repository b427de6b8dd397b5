"""Poses as arrays: which columns are controlled, how ry completes a controlled pose, angles wrapped to one turn."""

import numpy as np

from pipeline.arrays import FloatArray

CONTROLLED = np.array([0, 1, 2, 3, 5])
"""Columns of the controlled coordinates x, y, z, rx, rz in a pose (x, y, z, rx, ry, rz)."""
TILT_AXES = ("rx", "rz")
"""The controlled tilts, in the order of `TILT_COLUMNS`."""
TILT_COLUMNS = [3, 5]
"""Columns of the tilts rx, rz in a pose."""
RY = 4
"""Column of the dependent angle ry in a pose."""


def full_pose(controlled: FloatArray, ry_rad: FloatArray) -> FloatArray:
    """Insert ry (n,) into controlled poses (n, 5). Shape (n, 6)."""
    return np.column_stack([controlled[:, :4], ry_rad, controlled[:, 4]])


def wrap_angle(angle: FloatArray) -> FloatArray:
    """Wrap angles to (-pi, pi]. Same shape."""
    return np.asarray(np.pi - np.mod(np.pi - angle, 2.0 * np.pi), dtype=float)
