"""Functions of a box's six coordinates: value and gradient at its middle in enclosures, second derivatives all over it.

f(x) = f(m) + f'(m) (x - m) + w, |w| <= 1/2 sum |f_jk''| r_j r_k, for |x - m| <= r.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, exactly
from pipeline.certify.recheck.arithmetic.jets import TERMS, sine_cosine

COORDINATES = 6
_UP = 1.0 + 1e-12
"""More than all roundings of sums of fewer than 1,000 products of bounds, none of which is negative."""
_TINY = 1e-290
_ANYTHING = 1e30
"""Radius of what is not bounded: no box with it is verified, and nothing overflows."""


@dataclass(frozen=True, eq=False)
class Taylor:
    """Value (n,), gradient (6, n), bounds of second derivatives (6, 6, n), and half widths of the boxes (6, n)."""

    value: Enclosure
    slope: Enclosure
    bend: FloatArray
    half: FloatArray

    def __add__(self, other: "Taylor") -> "Taylor":
        return Taylor(
            self.value + other.value, self.slope + other.slope, (self.bend + other.bend) * _UP + _TINY, self.half
        )

    def __sub__(self, other: "Taylor") -> "Taylor":
        return self + other * -1.0

    def __mul__(self, other: "Taylor | float | Enclosure") -> "Taylor":
        if not isinstance(other, Taylor):
            factor = exactly(other) if isinstance(other, float) else other
            return Taylor(
                self.value * factor, self.slope * factor, self.bend * factor.magnitude * _UP + _TINY, self.half
            )
        crossed = self.steepest[:, None] * other.steepest
        bend = self.largest * other.bend + other.largest * self.bend + crossed + crossed.swapaxes(0, 1)
        slope = _row(self.value) * other.slope + _row(other.value) * self.slope
        return Taylor(self.value * other.value, slope, bend * _UP + _TINY, self.half)

    @property
    def rest(self) -> FloatArray:
        """Bound of the term of second order. Shape (n,)."""
        return np.asarray(0.5 * (self.bend * self.half[:, None] * self.half).sum(axis=(0, 1)) * _UP + _TINY)

    @property
    def largest(self) -> FloatArray:
        """Bound of |f| over the box. Shape (n,)."""
        linear = (self.slope.magnitude * self.half).sum(axis=0)
        return np.asarray((self.value.magnitude + linear + self.rest) * _UP)

    @property
    def steepest(self) -> FloatArray:
        """Bound of |f'| over the box. Shape (6, n)."""
        return np.asarray((self.slope.magnitude + (self.bend * self.half).sum(axis=1)) * _UP)

    @property
    def range(self) -> tuple[FloatArray, FloatArray]:
        """Bounds of f over the box."""
        far = ((self.slope.magnitude * self.half).sum(axis=0) + self.rest) * _UP
        return self.value.lower - far * _UP, self.value.upper + far * _UP


def known(value: Enclosure, half: FloatArray) -> Taylor:
    """Make a constant."""
    n = half.shape[1]
    return Taylor(
        Enclosure(np.broadcast_to(value.mid, (n,)), np.broadcast_to(value.rad, (n,))),
        exactly(np.zeros_like(half)),
        np.zeros((COORDINATES, COORDINATES, n)),
        half,
    )


def coordinate(k: int, middle: FloatArray, half: FloatArray) -> Taylor:
    """Make coordinate k of boxes, middles and half widths (6, n)."""
    slope = np.zeros_like(half)
    slope[k] = 1.0
    bend = np.zeros((COORDINATES, COORDINATES, half.shape[1]))
    return Taylor(exactly(middle[k]), exactly(slope), bend, half)


def cosine_sine(k: int, middle: FloatArray, half: FloatArray) -> tuple[Taylor, Taylor]:
    """Compute cosine and sine of coordinate k; their second derivatives are at most 1."""
    series = np.zeros((TERMS, half.shape[1]))
    series[0] = middle[k]
    sine, cosine = sine_cosine(exactly(series))
    bend = np.zeros((COORDINATES, COORDINATES, half.shape[1]))
    bend[k, k] = 1.0
    parts = []
    for value, by in ((cosine[0], -sine[0]), (sine[0], cosine[0])):
        mid, rad = np.zeros_like(half), np.zeros_like(half)
        mid[k], rad[k] = by.mid, by.rad
        parts.append(Taylor(value, Enclosure(mid, rad), bend, half))
    return parts[0], parts[1]


def inverse_root(square: Taylor, least: float) -> Taylor:
    """Compute a^(-1/2), by its derivatives -a^(-3/2) / 2 and 3/4 a^(-5/2); not bounded unless a > least everywhere."""
    low, a = square.range[0], square.value
    inside = low > least
    low, middle = np.where(inside, low, least), np.where(inside, a.mid, least)
    f = 1.0 / np.sqrt(middle)
    # The derivatives are largest at the least a: that bounds what the radius of a changes.
    steep, bent = 0.5 / least**1.5, 0.75 / least**2.5
    value = Enclosure(f, np.where(inside, steep * a.rad * _UP + 1e-14 * f, _ANYTHING))
    slope = Enclosure(-0.5 * f / middle, bent * a.rad * _UP + 1e-14 * f / middle)
    steepest = square.steepest
    bend = 0.75 / low**2.5 * steepest[:, None] * steepest + 0.5 / low**1.5 * square.bend
    return Taylor(value, _row(slope) * square.slope, bend * _UP * _UP + _TINY, square.half)


def _row(value: Enclosure) -> Enclosure:
    return Enclosure(value.mid[None], value.rad[None])
