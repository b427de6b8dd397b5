"""Bounds of actuators and tilts over a proven box."""

import numpy as np
from flint import arb

from pipeline.arrays import FloatArray
from pipeline.inclusion.condition import above, below
from pipeline.inclusion.pieces import middle
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.inclusion.ranges import polynomial_range
from pipeline.machine.pose import TILT_COLUMNS


def actuator_ranges(box: ProvenBox) -> FloatArray:
    """Bound the actuators over a box from below and above, shape (5, 2)."""
    interval = box.inclusion.box
    centre, _ = middle(interval.first, interval.last)
    coefficients = ([arb(value) for value in q] for q in box.piece.taylor(centre))
    ranges = [polynomial_range(q, box.series.half) for q in coefficients]
    return np.array([(below(least), above(largest)) for least, largest in ranges])


def tilt_magnitudes(box: ProvenBox) -> FloatArray:
    """Bound |rx| and |rz| over a box from above, shape (2,)."""
    bounds = []
    for column in TILT_COLUMNS:
        cubic = [arb(value) for value in box.inclusion.box.pose[:, column].tolist()]
        least, largest = polynomial_range(cubic, box.series.half)
        bounds.append(above(largest.max(-least) + box.inclusion.image[column]))
    return np.array(bounds)
