"""The splines of a path for many boxes at a time: Taylor coefficients, and whether a knot lies within a box."""

from math import factorial

import numpy as np
from scipy.interpolate import BSpline

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, exactly, stacked


def on_one_piece(spline: BSpline, first: FloatArray, last: FloatArray) -> BoolArray:
    """Return which intervals of s, with ends (n,), have no knot between their ends. Shape (n,)."""
    knots = np.unique(spline.t)
    begins, ends = np.searchsorted(knots, first, side="right"), np.searchsorted(knots, last, side="left")
    return np.asarray(begins >= ends, dtype=bool)


def spline_taylor(
    knots: FloatArray, coefficients: FloatArray, degree: int, first: FloatArray, centre: FloatArray
) -> Enclosure:
    """Compute Taylor coefficients (degree + 1, 5, n) of a spline about centres (n,), on the pieces that hold `first`.

    Beyond the ends these are the first and the last piece. Control points of a derivative are scaled differences of
    those of the derivative before; its values follow by de Boor's scheme.
    """
    # Knots at the ends of the domain may be repeated any number of times.
    least = np.searchsorted(knots, knots[degree], side="right") - 1
    largest = np.searchsorted(knots, knots[-degree - 1], side="left") - 1
    span = np.clip(np.searchsorted(knots, first, side="right") - 1, least, largest)
    points = [exactly(coefficients[span - degree + i].T) for i in range(degree + 1)]
    result = []
    for r in range(degree + 1):
        value = _de_boor(knots, points, degree - r, span, centre)
        result.append(value * exactly(float(factorial(r))).inverse())
        order = degree - r
        points = [
            (points[i + 1] - points[i])
            * exactly(float(order))
            * (exactly(knots[span + 1 + i]) - exactly(knots[span - order + 1 + i])).inverse()
            for i in range(order)
        ]
    return stacked(result)


def _de_boor(knots: FloatArray, points: list[Enclosure], degree: int, span: IntArray, s: FloatArray) -> Enclosure:
    at = exactly(s)
    for level in range(1, degree + 1):
        count = degree - level + 1
        blended = []
        for i in range(count):
            left, right = exactly(knots[span - degree + level + i]), exactly(knots[span + 1 + i])
            share = (right - left).inverse()
            blended.append(((right - at) * share) * points[i] + ((at - left) * share) * points[i + 1])
        points = blended
    return points[0]
