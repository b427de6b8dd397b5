"""Ranges of polynomials with balls for coefficients, over |u| <= d.

A polynomial f is within d^2 / 2 max|f''| of the line between its values at both ends (the error of linear
interpolation), so that

    |f| <= max(|f(-d)|, |f(d)|) + d^2 / 2 sum n (n - 1) |f_n| d^(n-2).
"""

from flint import arb, arb_poly


def enclosure(polynomial: arb_poly, half: arb) -> arb:
    """Enclose a polynomial over |u| <= half in a ball."""
    value, *slopes = polynomial.coeffs() or [arb(0)]
    spread = sum((slope.abs_upper() * half**n for n, slope in enumerate(slopes, start=1)), arb(0))
    return value + arb(0, spread.upper())


def magnitude(polynomial: arb_poly, half: arb) -> arb:
    """Bound |polynomial| over |u| <= half."""
    ends = polynomial(half).abs_upper().max(polynomial(-half).abs_upper())
    return (ends + _curvature(polynomial, half)).abs_upper()


def extremes(polynomial: arb_poly, half: arb) -> tuple[arb, arb]:
    """Bound a polynomial over |u| <= half from below and above, by the line between its ends as above."""
    ends = [polynomial(half), polynomial(-half)]
    bend = _curvature(polynomial, half)
    return ends[0].lower().min(ends[1].lower()) - bend, ends[0].upper().max(ends[1].upper()) + bend


def _curvature(polynomial: arb_poly, half: arb) -> arb:
    """Bound how far a polynomial is from the line between its ends."""
    sizes = (n * (n - 1) * value.abs_upper() * half ** (n - 2) for n, value in enumerate(polynomial.coeffs()) if n > 1)
    return (sum(sizes, arb(0)) * half * half / 2).abs_upper()
