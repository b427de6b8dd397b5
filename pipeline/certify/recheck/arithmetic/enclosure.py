"""Arrays of intervals in plain floats, as middles and radii; radii include all possible rounding errors.

Operations of IEEE arithmetic, rounded to nearest, have a relative error of at most u = 2^-53, and where they underflow
an absolute one of at most 2^-1075. Sums of n products have an error of at most n u times the sum of their magnitudes,
in any order of summation, fused or not, plus n times that absolute error.

This holds for all floats: an interval whose middle or radius is not finite, as after an overflow, holds every number.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.arrays import FloatArray

_U = 2.0**-53
_TINY = 1e-290
"""More than underflow loses in any operation here: none multiplies three numbers before it is added."""


@dataclass(frozen=True, eq=False)
class Enclosure:
    """Intervals mid +/- rad, two arrays of one shape; every number where one of them is infinite or NaN."""

    mid: FloatArray
    rad: FloatArray

    def __add__(self, other: "Enclosure") -> "Enclosure":
        mid = self.mid + other.mid
        return Enclosure(mid, rounded_up(self.rad + other.rad + _U * np.abs(mid), 4))

    def __neg__(self) -> "Enclosure":
        return Enclosure(-self.mid, self.rad)

    def __sub__(self, other: "Enclosure") -> "Enclosure":
        return self + -other

    def __mul__(self, other: "Enclosure") -> "Enclosure":
        mid = self.mid * other.mid
        rad = np.abs(self.mid) * other.rad + self.rad * (np.abs(other.mid) + other.rad) + _U * np.abs(mid)
        return Enclosure(mid, rounded_up(rad, 8))

    def __getitem__(self, index: Any) -> "Enclosure":
        return Enclosure(self.mid[index], self.rad[index])

    def inverse(self) -> "Enclosure":
        """Compute 1 / x; the radius is infinite if x holds zero.

        |1/y - 1/m| <= r / (|m| (|m| - r)) for y within m +/- r. The product could overflow, or lose its digits to
        underflow; the quotients one after the other cannot: r / |m| underflows only where |m| is above 1e-16.
        """
        size = np.abs(self.mid)
        with np.errstate(all="ignore"):
            mid = 1.0 / self.mid
            rad = rounded_up(self.rad / size / (size - self.rad) + 2.0 * _U * np.abs(mid), 8)
        regular = (size > self.rad) & np.isfinite(mid) & np.isfinite(size)
        return Enclosure(np.where(regular, mid, 0.0), np.where(regular, rad, np.inf))

    def take(self, indices: list[int], axis: int) -> "Enclosure":
        """Select indices along an axis."""
        return Enclosure(self.mid.take(indices, axis), self.rad.take(indices, axis))

    @property
    def magnitude(self) -> FloatArray:
        """Largest absolute value."""
        return rounded_up(np.abs(self.mid) + self.rad, 2)

    @property
    def lower(self) -> FloatArray:
        """Lower bound."""
        return np.asarray(np.nextafter(self.mid - self.rad, -np.inf), dtype=float)

    @property
    def upper(self) -> FloatArray:
        """Upper bound."""
        return np.asarray(np.nextafter(self.mid + self.rad, np.inf), dtype=float)


def exactly(values: object) -> Enclosure:
    """Convert floats to intervals without width; what is not finite may be any number."""
    mid = np.asarray(values, dtype=float)
    return Enclosure(mid, np.where(np.isfinite(mid), 0.0, np.inf))


def within(radius: FloatArray) -> Enclosure:
    """Make intervals about zero."""
    return Enclosure(np.zeros_like(radius), radius)


def constant(series: Enclosure, radius: FloatArray) -> Enclosure:
    """Keep the constant terms of series, with other radii."""
    mid, rad = np.zeros_like(series.mid), np.zeros_like(series.rad)
    mid[0], rad[0] = series.mid[0], radius
    return Enclosure(mid, rad)


def spread(values: Enclosure, axis: int) -> Enclosure:
    """Insert an axis of length one, as `numpy.expand_dims` does."""
    return Enclosure(np.expand_dims(values.mid, axis), np.expand_dims(values.rad, axis))


def contract(subscripts: str, a: Enclosure, b: Enclosure, terms: int) -> Enclosure:
    """Compute sums of products (`numpy.einsum`) of the given number of terms."""
    mid = np.einsum(subscripts, a.mid, b.mid)
    sizes = np.abs(a.mid), np.abs(b.mid)
    rad = (
        np.einsum(subscripts, sizes[0], b.rad)
        + np.einsum(subscripts, a.rad, sizes[1] + b.rad)
        + (terms + 1) * _U * np.einsum(subscripts, *sizes)
    )
    return Enclosure(mid, rounded_up(rad, 2 * terms + 8))


def dot(a: Enclosure, b: Enclosure, axis: int) -> Enclosure:
    """Compute scalar products of vectors with their three coordinates along an axis."""
    product = a * b
    (x, y, z) = (product.take([k], axis) for k in range(3))
    sum_of_all = x + y + z
    return Enclosure(sum_of_all.mid.squeeze(axis), sum_of_all.rad.squeeze(axis))


def cross(a: Enclosure, b: Enclosure, axis: int) -> Enclosure:
    """Compute vector products of vectors with their three coordinates along an axis."""
    forward, backward = [1, 2, 0], [2, 0, 1]
    return a.take(forward, axis) * b.take(backward, axis) - a.take(backward, axis) * b.take(forward, axis)


def bound(subscripts: str, a: FloatArray, b: FloatArray, terms: int) -> FloatArray:
    """Compute sums of products of bounds that are not negative, rounded up."""
    return rounded_up(np.einsum(subscripts, a, b), 2 * terms + 4)


def total(*bounds: FloatArray) -> FloatArray:
    """Compute the sum of bounds that are not negative, rounded up; each may be one product, quotient or difference."""
    result = bounds[0]
    for other in bounds[1:]:
        result = result + other
    return rounded_up(result, 2 * len(bounds) + 2)


def times(*bounds: FloatArray) -> FloatArray:
    """Compute the product of bounds that are not negative, rounded up after every factor."""
    result = bounds[0]
    for other in bounds[1:]:
        result = rounded_up(result * other, 1)
    return result


def root(values: FloatArray) -> FloatArray:
    """Compute square roots, rounded up."""
    return rounded_up(np.sqrt(values), 2)


def stacked(parts: list[Enclosure], axis: int = 0) -> Enclosure:
    """Stack enclosures of one shape along a new axis."""
    return Enclosure(np.stack([part.mid for part in parts], axis), np.stack([part.rad for part in parts], axis))


def rounded_up(values: FloatArray, roundings: int) -> FloatArray:
    """Enlarge values computed with the given number of roundings to upper bounds of the exact values."""
    return np.asarray(values * (1.0 + 2.0 * (roundings + 1) * _U) + _TINY, dtype=float)


def rounded_down(values: FloatArray, roundings: int) -> FloatArray:
    """Diminish positive values computed with the given number of roundings to lower bounds of the exact values."""
    return np.asarray(values * (1.0 - 2.0 * (roundings + 1) * _U) - _TINY, dtype=float)
