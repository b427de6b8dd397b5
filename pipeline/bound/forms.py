"""Quadratic forms of many boxes at a time, with outward rounding: c + sum g_i x_i + sum q_ij x_i x_j + e y.

x_1 ... x_N in [-1, 1] are the box's own coordinates, shared by all forms; what is of third order in them, and every
rounding, is part of the error e, y in [-1, 1]. An operation of IEEE arithmetic is off by at most u = 2^-53 of its
result; as all terms of an operation are at most the product or sum of its operands' sizes, so is each of its roundings.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.arrays import FloatArray, IntArray

_UNIT = 64.0 * 2.0**-53
"""More than all roundings of one operation, relative to the size of its terms: each has fewer than 60."""
_TINY = 1e-300
_SINE_SLACK = 1e-14
"""More than sine and cosine of the platform's library are off; the tests compare them with ball arithmetic."""


@dataclass(frozen=True, eq=False)
class Form:
    """Quadratic forms of n boxes.

    Attributes
    ----------
    c : (..., n)
        Constants.
    g : (N, ..., n)
        Coefficients of x_i.
    q : (N (N + 1) / 2, ..., n)
        Coefficients of x_i x_j, i <= j, row by row as in `pairs`.
    e : (..., n)
        Bound of the rest.
    size : (..., n)
        Bound of the sum of all magnitudes.
    """

    c: FloatArray
    g: FloatArray
    q: FloatArray
    e: FloatArray
    size: FloatArray

    def __add__(self, other: "Form") -> "Form":
        size = self.size + other.size
        e = (self.e + other.e) * (1.0 + _UNIT) + _UNIT * size
        return Form(self.c + other.c, self.g + other.g, self.q + other.q, e, size)

    def __neg__(self) -> "Form":
        return Form(-self.c, -self.g, -self.q, self.e, self.size)

    def __sub__(self, other: "Form") -> "Form":
        size = self.size + other.size
        e = (self.e + other.e) * (1.0 + _UNIT) + _UNIT * size
        return Form(self.c - other.c, self.g - other.g, self.q - other.q, e, size)

    def __mul__(self, other: "Form") -> "Form":
        """Multiply; terms of third and fourth order go into the error."""
        a, b = _total(self.g), _total(other.g)
        A, B = _total(self.q), _total(other.q)
        size = self.size * other.size
        e = np.abs(self.c) * other.e + np.abs(other.c) * self.e + self.e * (other.e + b + B) + other.e * (a + A)
        e += a * B + A * (b + B)
        q = self.c * other.q + other.c * self.q
        row = 0
        N = len(self.g)
        for i in range(N):
            q[row : row + N - i] += self.g[i] * other.g[i:]
            if i + 1 < N:
                q[row + 1 : row + N - i] += other.g[i] * self.g[i + 1 :]
            row += N - i
        return Form(self.c * other.c, self.c * other.g + other.c * self.g, q, e * (1.0 + _UNIT) + _UNIT * size, size)

    def times(self, factor: Any) -> "Form":
        """Multiply by a float, or an array of them that fits the centre."""
        factor = np.asarray(factor, dtype=float)
        size = self.size * np.abs(factor)
        return Form(
            self.c * factor,
            self.g * factor,
            self.q * factor,
            self.e * np.abs(factor) * (1.0 + _UNIT) + _UNIT * size + _TINY,
            size,
        )

    def plus(self, constant: Any) -> "Form":
        """Add a float, or an array of them that fits the centre."""
        size = self.size + np.abs(constant)
        return Form(self.c + constant, self.g, self.q, self.e * (1.0 + _UNIT) + _UNIT * size, size)

    def __getitem__(self, index: Any) -> "Form":
        """Select along the first axes of the centre."""
        index = index if isinstance(index, tuple) else (index,)
        return Form(
            self.c[index], self.g[(slice(None), *index)], self.q[(slice(None), *index)], self.e[index], self.size[index]
        )

    def boxes(self, keep: IntArray) -> "Form":
        """Select boxes (m,)."""
        return Form(*(np.take(part, keep, axis=-1) for part in (self.c, self.g, self.q, self.e, self.size)))

    @property
    def expanded(self) -> "Form":
        """The same with an axis before the last, to multiply vectors by it."""
        return Form(*(np.expand_dims(part, -2) for part in (self.c, self.g, self.q, self.e, self.size)))

    @property
    def radius(self) -> FloatArray:
        """Largest distance from the constant, rounded up."""
        return np.asarray((_total(self.g) + _total(self.q) + self.e) * (1.0 + _UNIT), dtype=float)

    @property
    def lower(self) -> FloatArray:
        """Lower bound; squares count only where they subtract."""
        return np.asarray(self.c - self._reach(-1.0), dtype=float)

    @property
    def upper(self) -> FloatArray:
        """Upper bound; squares count only where they add."""
        return np.asarray(self.c + self._reach(1.0), dtype=float)

    def _reach(self, sign: float) -> FloatArray:
        far = _total(self.g) + quadratic_upper(self.q * sign, len(self.g)) + self.e
        return np.asarray(far * (1.0 + _UNIT) + _UNIT * self.size)


def _total(x: FloatArray) -> FloatArray:
    return np.asarray(np.abs(x).sum(axis=0))


def pairs(N: int) -> tuple[Any, Any]:
    """Give i and j of the coefficients of x_i x_j, in their order."""
    return np.triu_indices(N)


def quadratic_upper(q: FloatArray, N: int) -> FloatArray:
    """Bound sum q_ij x_i x_j from above, x in [-1, 1]: squares count only where they add."""
    i, j = pairs(N)
    square = (i == j).reshape(-1, *[1] * (q.ndim - 1))
    return np.asarray(np.where(square, np.maximum(q, 0.0), np.abs(q)).sum(axis=0))


def constant(value: FloatArray, symbols: int, error: FloatArray | float = 0.0) -> Form:
    """Make forms of constants (..., n), known to within an error."""
    value = np.asarray(value, dtype=float)
    e = np.broadcast_to(np.asarray(error, dtype=float), value.shape)
    return Form(value, *_zeros(symbols, value), e, np.abs(value) + e)


def _zeros(N: int, like: FloatArray) -> tuple[FloatArray, FloatArray]:
    return np.zeros((N, *like.shape)), np.zeros((N * (N + 1) // 2, *like.shape))


def linear(c: FloatArray, g: FloatArray) -> Form:
    """Make forms of constants (..., n) and coefficients (N, ..., n)."""
    return Form(c, g, _zeros(len(g), c)[1], np.zeros_like(c), np.abs(c) + _total(g) * (1.0 + _UNIT))


def coordinate(middle: FloatArray, half: FloatArray, symbol: int | None, symbols: int) -> Form:
    """Make a coordinate of boxes, its middle and half width (n,); without a symbol it is constant."""
    g, q = _zeros(symbols, middle)
    if symbol is None:
        return Form(middle, g, q, half, np.abs(middle) + half)
    g[symbol] = half
    return Form(middle, g, q, np.zeros_like(half), np.abs(middle) + half)


def cosine_sine(angle: FloatArray, half: FloatArray, symbol: int | None, symbols: int) -> tuple[Form, Form]:
    """Compute cosine and sine of a coordinate: f + f' h x - f h^2 x^2 / 2 + r, |r| <= h^3 / 6."""
    values = np.cos(angle), np.sin(angle)
    return (
        _second_order(values[0], -values[1], half, symbol, symbols),
        _second_order(values[1], values[0], half, symbol, symbols),
    )


def _second_order(f: FloatArray, slope: FloatArray, half: FloatArray, symbol: int | None, symbols: int) -> Form:
    g, q = _zeros(symbols, f)
    if symbol is None:
        rest = half
    else:
        rest = half**3 / 6.0
        g[symbol] = slope * half
        q[symbol * symbols - symbol * (symbol - 1) // 2] = -0.5 * f * half**2
    e = (rest + _SINE_SLACK) * (1.0 + _UNIT) + _UNIT
    return Form(f, g, q, e, 1.0 + half + half**2 + half**3)


def inverse_root(square: Form, least: float, largest: float) -> Form:
    """Compute 1 / sqrt(a) for those values of a that lie within the given bounds.

    With d = a - m, m near the centre: m^(-1/2) - m^(-3/2) d / 2 + 3 m^(-5/2) d^2 / 8 + r, |r| <= 5 / 16 t^(-7/2) |d|^3
    with t the least a or m.
    """
    low, high = np.maximum(square.lower, least), np.minimum(square.upper, largest)
    middle = np.clip(square.c, least, largest)
    f = 1.0 / np.sqrt(middle)
    far = np.maximum(high - middle, middle - low) * (1.0 + _UNIT) + _UNIT * square.size
    bottom = np.minimum(np.maximum(low, least), middle) * (1.0 - _UNIT)
    rest = 0.3125 * far**3 / (bottom**3 * np.sqrt(bottom)) * (1.0 + _UNIT)
    d = square.plus(-middle)
    series = (d * d).times(0.375 * f / middle**2) + d.times(-0.5 * f / middle)
    found = series.plus(f)
    return Form(
        found.c, found.g, found.q, (found.e + rest) * (1.0 + _UNIT) + 8.0 * _UNIT * found.size, found.size + rest
    )


def joined(forms: list[Form], axis: int = 0) -> Form:
    """Stack forms along a new axis of the centre."""
    parts = ("c", 0), ("g", 1), ("q", 1), ("e", 0), ("size", 0)
    return Form(*(np.stack([getattr(form, name) for form in forms], axis + after) for name, after in parts))


def cross(a: Form, b: Form) -> Form:
    """Compute cross products of vectors (..., 3, n)."""
    parts = []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        parts.append(a[..., j, :] * b[..., k, :] - a[..., k, :] * b[..., j, :])
    return joined(parts, axis=a.c.ndim - 2)


def sum_of(forms: list[Form]) -> Form:
    """Add forms."""
    total = forms[0]
    for form in forms[1:]:
        total = total + form
    return total
