"""A path's splines as exact polynomials between knots: floats are rational numbers.

There is neither sampling nor rounding: B-spline coefficients become Bernstein coefficients by blossoming, and these
become Taylor coefficients by expansion, all in rational arithmetic.
"""

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import comb

import numpy as np
from flint import fmpq, fmpq_poly
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Piece:
    """The actuators between two neighbouring knots: q_k(s) = polynomials[k](s - first), exactly.

    Attributes
    ----------
    first, last : float
        The knots.
    polynomials : tuple of fmpq_poly
        One per actuator.
    """

    first: float
    last: float
    polynomials: tuple[fmpq_poly, ...]

    def taylor(self, s: float) -> list[list[fmpq]]:
        """Expand each actuator about s, exactly: q_k(s + t) = sum of taylor[k][n] t^n."""
        shift = fmpq_poly([exact(s) - exact(self.first), fmpq(1)])
        return [polynomial(shift).coeffs() or [fmpq(0)] for polynomial in self.polynomials]


def exact(value: float) -> fmpq:
    """Convert a float to the rational number it represents."""
    return fmpq(*float(value).as_integer_ratio())


def pieces(spline: BSpline) -> list[Piece]:
    """Split a B-spline of shape (n, 5) into its polynomial pieces over [0, 1]."""
    knots = [exact(knot) for knot in spline.t]
    coefficients = [[exact(value) for value in column] for column in np.asarray(spline.c).T]
    breaks = distinct_knots(spline)
    found = []
    for first, last in pairwise(breaks):
        span = int(np.searchsorted(spline.t, first, side="right")) - 1
        polynomials = tuple(_piece(knots, column, spline.k, span) for column in coefficients)
        found.append(Piece(float(first), float(last), polynomials))
    return found


def distinct_knots(spline: BSpline) -> FloatArray:
    """Return the knots of a spline within its domain, each once."""
    return np.unique(spline.t[spline.k : len(spline.t) - spline.k])


def _piece(knots: list[fmpq], coefficients: list[fmpq], degree: int, span: int) -> fmpq_poly:
    """Compute the polynomial over [t_span, t_span+1] in s - t_span from its Bernstein coefficients."""
    first, last = knots[span], knots[span + 1]
    along = fmpq_poly([fmpq(0), 1 / (last - first)])
    rest = 1 - along
    total = fmpq_poly([fmpq(0)])
    for j in range(degree + 1):
        bernstein = _blossom(knots, coefficients, degree, span, [first] * (degree - j) + [last] * j)
        total += bernstein * comb(degree, j) * along**j * rest ** (degree - j)
    return total


def _blossom(knots: list[fmpq], coefficients: list[fmpq], degree: int, span: int, arguments: list[fmpq]) -> fmpq:
    """Evaluate the polar form of a piece at `degree` arguments (de Boor's scheme with one argument per level)."""
    points = coefficients[span - degree : span + 1]
    for level, argument in enumerate(arguments, start=1):
        points = [
            (
                (knots[span + 1 + i] - argument) * points[i]
                + (argument - knots[span - degree + level + i]) * points[i + 1]
            )
            / (knots[span + 1 + i] - knots[span - degree + level + i])
            for i in range(degree - level + 1)
        ]
    return points[0]


def middle(first: float, last: float) -> tuple[float, float]:
    """Return the centre of [first, last], and a half-width that certainly reaches both ends."""
    centre = (first + last) / 2.0
    reach = max(Fraction(last) - Fraction(centre), Fraction(centre) - Fraction(first))
    half = float(reach)
    return centre, half if Fraction(half) >= reach else float(np.nextafter(half, np.inf))
