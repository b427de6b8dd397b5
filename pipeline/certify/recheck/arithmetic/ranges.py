"""Ranges of polynomials over the intervals of many boxes."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, exactly, within
from pipeline.certify.recheck.arithmetic.jets import expand

_PARTS = 16


def polynomial_ranges(coefficients: Enclosure, half: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bound polynomials with coefficients (orders, k, n) over |t| <= half (n,) from below and above, both (k, n)."""
    part, orders = half / _PARTS, len(coefficients.mid)
    lows, highs = [], []
    for k in range(_PARTS):
        about = expand(coefficients, exactly((2.0 * k + 1.0) * part - half), orders)
        spread = expand(about, within(part + 1e-12 * half), 1)[0]
        lows.append(spread.lower)
        highs.append(spread.upper)
    return np.min(lows, axis=0), np.max(highs, axis=0)
