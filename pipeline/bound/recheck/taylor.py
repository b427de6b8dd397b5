"""Functions of a box's coordinates by their Taylor polynomial at its middle: value, gradient, Hessian, and a bound.

f = value + slope . t + t' bend t + w, |w| <= rest, for t in [-1, 1]^N, distances from the middle in half widths.
Roundings are bounded by the magnitudes of all terms they come from, and are part of the rest.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, exactly
from pipeline.certify.recheck.arithmetic.jets import sine_cosine_of_values

_EPS = 2.0**-46
"""More than all roundings of one operation of fewer than 60 terms, relative to their magnitudes."""
_UP = 1.0 + 1e-12
"""More than all roundings of sums of fewer than 1,000 products of bounds, none of which is negative."""
_TINY = 1e-290


@dataclass(frozen=True, eq=False)
class Taylor:
    """Arrays of functions on n boxes: value (..., n), slope (N, ..., n), bend (N, N, ..., n), rest and mass (..., n).

    mass bounds the sum of all magnitudes.
    """

    value: FloatArray
    slope: FloatArray
    bend: FloatArray
    rest: FloatArray
    mass: FloatArray

    def __add__(self, other: "Taylor") -> "Taylor":
        return self._summed(other, 1.0)

    def __sub__(self, other: "Taylor") -> "Taylor":
        return self._summed(other, -1.0)

    def _summed(self, other: "Taylor", sign: float) -> "Taylor":
        mass = self.mass + other.mass
        return Taylor(
            self.value + sign * other.value,
            self.slope + sign * other.slope,
            self.bend + sign * other.bend,
            (self.rest + other.rest) * _UP + _EPS * mass,
            mass,
        )

    def __mul__(self, other: "Taylor") -> "Taylor":
        f, g = self.value, other.value
        first, second = (self._line, self._curve), (other._line, other._curve)
        mass = self.mass * other.mass
        rest = (np.abs(f) + first[0] + first[1]) * other.rest + (np.abs(g) + second[0] + second[1]) * self.rest
        rest = rest + self.rest * other.rest + first[0] * second[1] + first[1] * (second[0] + second[1])
        bend = f * other.bend + g * self.bend + self.slope[:, None] * other.slope
        return Taylor(f * g, f * other.slope + g * self.slope, bend, rest * _UP + _EPS * mass + _TINY, mass)

    def scaled(self, factor: Any) -> "Taylor":
        """Multiply by numbers that are off by a few roundings at most."""
        size = np.abs(factor)
        mass = self.mass * size
        return Taylor(
            self.value * factor, self.slope * factor, self.bend * factor, self.rest * size * _UP + _EPS * mass, mass
        )

    def shifted(self, by: Any) -> "Taylor":
        """Add numbers that are off by a few roundings at most."""
        mass = self.mass + np.abs(by)
        return Taylor(self.value + by, self.slope, self.bend, self.rest * _UP + _EPS * mass, mass)

    def mapped(self, matrix: FloatArray) -> "Taylor":
        """Apply a matrix (m, k), off by a few roundings at most, to the first axis (k, ...)."""
        size = np.abs(matrix)
        mass = np.einsum("mk,k...->m...", size, self.mass)
        rest = np.einsum("mk,k...->m...", size, self.rest)
        return Taylor(
            np.einsum("mk,k...->m...", matrix, self.value),
            np.einsum("mk,ik...->im...", matrix, self.slope),
            np.einsum("mk,ijk...->ijm...", matrix, self.bend),
            rest * _UP + _EPS * mass,
            mass,
        )

    def __getitem__(self, index: Any) -> "Taylor":
        """Select along the first axes."""
        index = index if isinstance(index, tuple) else (index,)
        every = slice(None)
        return Taylor(
            self.value[index],
            self.slope[every, *index],
            self.bend[every, every, *index],
            self.rest[index],
            self.mass[index],
        )

    def at(self, boxes: Any) -> "Taylor":
        """Select boxes."""
        return Taylor(*(np.take(part, boxes, axis=-1) for part in self._parts))

    def expanded(self) -> "Taylor":
        """Add an axis before the last."""
        return Taylor(*(np.expand_dims(part, -2) for part in self._parts))

    @property
    def _parts(self) -> tuple[FloatArray, ...]:
        return self.value, self.slope, self.bend, self.rest, self.mass

    @property
    def _line(self) -> FloatArray:
        return np.asarray(np.abs(self.slope).sum(axis=0))

    @property
    def _curve(self) -> FloatArray:
        return np.asarray(np.abs(self.bend).sum(axis=(0, 1)))

    @property
    def largest(self) -> FloatArray:
        """Bound of |f| over the box."""
        return np.asarray((np.abs(self.value) + self._line + self._curve + self.rest) * _UP)

    @property
    def range(self) -> tuple[FloatArray, FloatArray]:
        """Bounds of f over the box."""
        down, up = (self._line + one_sided(sign * self.bend) + self.rest for sign in (-1.0, 1.0))
        slack = _EPS * self.mass
        return self.value - down * _UP - slack, self.value + up * _UP + slack


def one_sided(bend: FloatArray) -> FloatArray:
    """Bound t' B t from above, B (N, N, ...): t_k^2 lies in [0, 1]."""
    both = 0.5 * np.abs(bend + bend.swapaxes(0, 1)).sum(axis=(0, 1))
    squares = np.stack([bend[k, k] for k in range(len(bend))])
    return np.asarray(both + np.minimum(squares, 0.0).sum(axis=0))


def stack(parts: list[Taylor], axis: int = 0) -> Taylor:
    """Stack functions along a new axis."""
    return Taylor(
        np.stack([p.value for p in parts], axis),
        np.stack([p.slope for p in parts], axis + 1),
        np.stack([p.bend for p in parts], axis + 2),
        np.stack([p.rest for p in parts], axis),
        np.stack([p.mass for p in parts], axis),
    )


def known(value: FloatArray, N: int) -> Taylor:
    """Make constants (..., n), off by a few roundings at most."""
    size = np.abs(value)
    return Taylor(value, *_zeros(N, value), _EPS * size, size)


def linear(value: FloatArray, slope: FloatArray) -> Taylor:
    """Make linear functions (n,) with slopes (N, n)."""
    zero = np.zeros_like(value)
    return Taylor(value, slope, _zeros(len(slope), value)[1], zero, np.abs(value) + np.abs(slope).sum(axis=0) * _UP)


def coordinate(symbol: int | None, middle: FloatArray, half: FloatArray, N: int) -> Taylor:
    """Make a coordinate of boxes, middles and half widths (n,); without a symbol it is exactly its middle."""
    slope, bend = _zeros(N, middle)
    if symbol is not None:
        slope[symbol] = half
    return Taylor(middle, slope, bend, np.zeros_like(half), np.abs(middle) + half)


def cosine_sine(symbol: int | None, middle: FloatArray, half: FloatArray, N: int) -> tuple[Taylor, Taylor]:
    """Compute cosine and sine of a coordinate: power series of half the angle, and third derivatives of at most 1."""
    s, c = sine_cosine_of_values(exactly(0.5 * middle))
    double = exactly(np.full_like(middle, 2.0))
    sine, cosine = double * s * c, exactly(np.ones_like(middle)) - double * s * s
    return _circular(cosine, -sine.mid, symbol, half, N), _circular(sine, cosine.mid, symbol, half, N)


def _circular(f: Enclosure, by: FloatArray, symbol: int | None, half: FloatArray, N: int) -> Taylor:
    slope, bend = _zeros(N, half)
    rest, mass = f.rad + 0.0, np.ones_like(half)
    if symbol is not None:
        slope[symbol], bend[symbol, symbol] = by * half, -0.5 * f.mid * half**2
        # Of the slope, and of the bend, enclosures are wider than zero, too: by less than 1e-13.
        rest = rest + half**3 / 6.0 + 1e-13 * (half + half**2)
        mass = mass + half + half**2 + half**3
    return Taylor(f.mid, slope, bend, rest * _UP + _EPS * mass, mass)


def inverse_root(square: Taylor, least: float, largest: float) -> Taylor:
    """Compute a^(-1/2) for values of a in [least, largest]; its third derivative is at most 15 / 8 a^(-7/2)."""
    low, high = (np.clip(bound, least, largest) for bound in square.range)
    m = np.clip(square.value, least, largest)
    f = 1.0 / np.sqrt(m)
    far = np.maximum(high - m, m - low) * _UP + _EPS * square.mass
    d = square.shifted(-m)
    near = (d * d).scaled(0.375 * f / m**2) - d.scaled(0.5 * f / m)
    found = near.shifted(f)
    third = 0.3125 * far**3 / np.minimum(low, m) ** 3.5 * _UP * _UP
    return Taylor(found.value, found.slope, found.bend, found.rest + third, found.mass + third)


def _zeros(N: int, like: FloatArray) -> tuple[FloatArray, FloatArray]:
    return np.zeros((N, *like.shape)), np.zeros((N, N, *like.shape))
