"""Ranges of polynomials over an interval: rigorous, and sharp since the interval is divided into parts."""

from flint import arb, arb_poly

_PARTS = 16


def polynomial_range(coefficients: list[arb], half: arb) -> tuple[arb, arb]:
    """Bound a polynomial in t for |t| <= half from below and above, by its expansions about the middles of parts."""
    least, largest = None, None
    part = half / _PARTS
    polynomial = arb_poly(coefficients)
    for k in range(_PARTS):
        middle = part * (2 * k + 1) - half
        value, *slopes = polynomial(arb_poly([middle, arb(1)])).coeffs() or [arb(0)]
        spread = sum((slope.abs_upper() * part**n for n, slope in enumerate(slopes, start=1)), arb(0))
        below, above = (value - spread).lower(), (value + spread).upper()
        least = below if least is None else least.min(below)
        largest = above if largest is None else largest.max(above)
    assert least is not None
    assert largest is not None
    return least, largest
