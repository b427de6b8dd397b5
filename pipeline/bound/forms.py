"""Affine forms of many boxes at a time, with outward rounding: c + g_1 x_1 + ... + g_N x_N + e y, x_i and y in [-1, 1].

x_1 ... x_N are the box's own coordinates, shared by all forms; what is not linear in them, and every rounding, is part
of the error e. An operation of IEEE arithmetic is off by at most u = 2^-53 of its result; as all terms of an operation
are at most the product or sum of its operands' sizes, so is each of its roundings.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.arrays import FloatArray

_UNIT = 64.0 * 2.0**-53
"""More than all roundings of one operation, relative to the size of its terms: each has fewer than 60."""
_TINY = 1e-300
_SINE_SLACK = 1e-14
"""More than sine and cosine of the platform's library are off; the tests compare them with ball arithmetic."""


@dataclass(frozen=True, eq=False)
class Form:
    """Affine forms: centre (..., n), coefficients (N, ..., n), error (..., n), and a bound of their size (..., n)."""

    c: FloatArray
    g: FloatArray
    e: FloatArray
    size: FloatArray

    def __add__(self, other: "Form") -> "Form":
        size = self.size + other.size
        e = (self.e + other.e) * (1.0 + _UNIT) + _UNIT * size
        return Form(self.c + other.c, self.g + other.g, e, size)

    def __neg__(self) -> "Form":
        return Form(-self.c, -self.g, self.e, self.size)

    def __sub__(self, other: "Form") -> "Form":
        return self + -other

    def __mul__(self, other: "Form") -> "Form":
        """Multiply; x_i^2 lies in [0, 1], which is half a constant and half an error."""
        a, b = np.abs(self.g).sum(axis=0), np.abs(other.g).sum(axis=0)
        squares = self.g * other.g
        half = 0.5 * squares.sum(axis=0)
        mixed = a * b - 0.5 * np.abs(squares).sum(axis=0)
        size = self.size * other.size
        e = np.abs(self.c) * other.e + np.abs(other.c) * self.e + self.e * other.e + self.e * b + other.e * a + mixed
        return Form(
            self.c * other.c + half, self.c * other.g + other.c * self.g, e * (1.0 + _UNIT) + _UNIT * size, size
        )

    def times(self, factor: Any) -> "Form":
        """Multiply by a float, or an array of them that fits the centre."""
        factor = np.asarray(factor, dtype=float)
        size = self.size * np.abs(factor)
        return Form(
            self.c * factor, self.g * factor, self.e * np.abs(factor) * (1.0 + _UNIT) + _UNIT * size + _TINY, size
        )

    def plus(self, constant: Any) -> "Form":
        """Add a float, or an array of them that fits the centre."""
        size = self.size + np.abs(constant)
        return Form(self.c + constant, self.g, self.e * (1.0 + _UNIT) + _UNIT * size, size)

    def __getitem__(self, index: Any) -> "Form":
        """Select along the first axes of the centre."""
        index = index if isinstance(index, tuple) else (index,)
        return Form(self.c[index], self.g[(slice(None), *index)], self.e[index], self.size[index])

    def boxes(self, keep: Any) -> "Form":
        """Select boxes."""
        return Form(self.c[..., keep], self.g[..., keep], self.e[..., keep], self.size[..., keep])

    @property
    def radius(self) -> FloatArray:
        """Largest distance from the centre, rounded up."""
        return np.asarray((np.abs(self.g).sum(axis=0) + self.e) * (1.0 + _UNIT), dtype=float)

    @property
    def lower(self) -> FloatArray:
        """Lower bound."""
        return np.asarray(self.c - (self.radius + _UNIT * self.size), dtype=float)

    @property
    def upper(self) -> FloatArray:
        """Upper bound."""
        return np.asarray(self.c + (self.radius + _UNIT * self.size), dtype=float)


def constant(value: FloatArray, symbols: int, error: FloatArray | float = 0.0) -> Form:
    """Make forms of constants (..., n), known to within an error."""
    value = np.asarray(value, dtype=float)
    e = np.broadcast_to(np.asarray(error, dtype=float), value.shape)
    return Form(value, np.zeros((symbols, *value.shape)), e, np.abs(value) + e)


def coordinate(middle: FloatArray, half: FloatArray, symbol: int | None, symbols: int) -> Form:
    """Make a coordinate of boxes, its middle and half width (n,); without a symbol it is constant."""
    g = np.zeros((symbols, *middle.shape))
    if symbol is None:
        return Form(middle, g, half, np.abs(middle) + half)
    g[symbol] = half
    return Form(middle, g, np.zeros_like(half), np.abs(middle) + half)


def cosine_sine(angle: FloatArray, half: FloatArray, symbol: int | None, symbols: int) -> tuple[Form, Form]:
    """Compute cosine and sine of a coordinate: f + f' h x - f h^2 x^2 / 2 + r, |r| <= h^3 / 6."""
    values = np.cos(angle), np.sin(angle)
    return (
        _second_order(values[0], -values[1], half, symbol, symbols),
        _second_order(values[1], values[0], half, symbol, symbols),
    )


def _second_order(f: FloatArray, slope: FloatArray, half: FloatArray, symbol: int | None, symbols: int) -> Form:
    bend = 0.25 * half**2
    g = np.zeros((symbols, *f.shape))
    rest = half**3 / 6.0 + np.abs(f) * bend
    if symbol is None:
        rest = rest + np.abs(slope) * half
    else:
        g[symbol] = slope * half
    e = (rest + _SINE_SLACK) * (1.0 + _UNIT) + _UNIT
    return Form(f * (1.0 - bend), g, e, 1.0 + half + half**2)


def inverse_root(square: Form, least: float, largest: float) -> Form:
    """Compute 1 / sqrt(a) for those values of a that lie within the given bounds.

    It is convex: above its tangent at the centre m, by at most 3 / 8 t^(-5/2) (a - m)^2 with t the least a or m.
    """
    low, high = np.maximum(square.lower, least), np.minimum(square.upper, largest)
    middle = np.clip(square.c, least, largest)
    f = 1.0 / np.sqrt(middle)
    slope = -0.5 * f / middle
    far = np.maximum(high - middle, middle - low) * (1.0 + _UNIT) + _UNIT * square.size
    bottom = np.minimum(np.maximum(low, least), middle) * (1.0 - _UNIT)
    bulge = 0.375 * far**2 / (bottom**2 * np.sqrt(bottom)) * (1.0 + _UNIT)
    size = f + np.abs(slope) * (square.size + middle) + bulge
    e = (np.abs(slope) * square.e + 0.5 * bulge) * (1.0 + _UNIT) + 4.0 * _UNIT * size
    return Form(f + slope * (square.c - middle) + 0.5 * bulge, slope * square.g, e, size)


def joined(forms: list[Form]) -> Form:
    """Stack forms along a new first axis of the centre."""
    return Form(
        np.stack([form.c for form in forms]),
        np.stack([form.g for form in forms], axis=1),
        np.stack([form.e for form in forms]),
        np.stack([form.size for form in forms]),
    )


def sum_of(forms: list[Form]) -> Form:
    """Add forms."""
    total = forms[0]
    for form in forms[1:]:
        total = total + form
    return total
