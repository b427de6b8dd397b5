"""Ranges of polynomials over the intervals of many boxes."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, exactly, total, within
from pipeline.certify.recheck.arithmetic.jets import expand

_MOST_PARTS = 16
_SHARP = 1e-7
"""What bounds may exceed the range by before an interval is divided, in its unit; the search adds more to them."""


def polynomial_ranges(coefficients: Enclosure, half: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bound polynomials with coefficients (orders, k, n) over |t| <= half (n,) from below and above, both (k, n)."""
    lows, highs = zip(*part_ranges(coefficients, half, _parts(coefficients, half)), strict=True)
    return np.min(lows, axis=0), np.max(highs, axis=0)


def part_ranges(coefficients: Enclosure, half: FloatArray, parts: int) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Bound polynomials with coefficients (orders, k, n) over each of equal parts of |t| <= half (n,), both (k, n)."""
    orders, part = len(coefficients.mid), half / parts
    for k in range(parts):
        middle = (2.0 * k + 1.0) * part - half
        about = expand(coefficients, exactly(middle), orders)
        # The middles and widths of parts are rounded.
        spread = expand(about, within(total(part, 1e-12 * half)), 1)[0]
        yield spread.lower, spread.upper


def _parts(coefficients: Enclosure, half: FloatArray) -> int:
    """Choose in how many parts to divide intervals: what is not linear is overestimated, and falls with the square."""
    sizes = np.abs(coefficients.mid[2:])
    beyond = sum((size * half**order for order, size in enumerate(sizes, start=2)), np.zeros(1)).max()
    if not beyond < _MOST_PARTS**2 * _SHARP:
        return _MOST_PARTS
    return max(1, int(np.ceil(np.sqrt(beyond / _SHARP))))
