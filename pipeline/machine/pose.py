"""Indices of coordinates within a pose (x, y, z, rx, ry, rz)."""

import numpy as np

CONTROLLED = np.array([0, 1, 2, 3, 5])
"""Where x, y, z, rx, rz are in a pose; ry follows from them."""

TILT_COLUMNS = [3, 5]
"""Where rx and rz are in a pose."""
