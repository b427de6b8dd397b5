"""Power series in s for many boxes at a time: arrays of enclosures whose first axis is the order."""

from collections.abc import Callable
from math import comb, factorial

import numpy as np

from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, exactly, stacked, times, total

TERMS = 5
_SINE_TERMS = 20
_LARGEST_ANGLE = 4.0


def product(multiply: Callable[[Enclosure, Enclosure], Enclosure], a: Enclosure, b: Enclosure) -> Enclosure:
    """Multiply two series, with `multiply` for their terms."""
    orders = []
    for n in range(TERMS):
        result = multiply(a[0], b[n])
        for k in range(1, n + 1):
            result = result + multiply(a[k], b[n - k])
        orders.append(result)
    return stacked(orders)


def sine_cosine(angle: Enclosure) -> tuple[Enclosure, Enclosure]:
    """Compute sine and cosine of a series: n s_n = sum k a_k c_(n-k), n c_n = -sum k a_k s_(n-k)."""
    first = sine_cosine_of_values(angle[0])
    sine, cosine = [first[0]], [first[1]]
    for n in range(1, TERMS):
        s, c = None, None
        for k in range(1, n + 1):
            slope = angle[k] * exactly(np.full(angle.mid.shape[1:], float(k)))
            ds, dc = slope * cosine[n - k], slope * sine[n - k]
            s, c = (ds, dc) if s is None or c is None else (s + ds, c + dc)
        assert s is not None
        assert c is not None
        share = exactly(float(n)).inverse()
        sine.append(s * share)
        cosine.append(-(c * share))
    return stacked(sine), stacked(cosine)


def sine_cosine_of_values(x: Enclosure) -> tuple[Enclosure, Enclosure]:
    """Evaluate Taylor series at zero for angles up to four; |sin(m + d) - sin m| <= |d cos m| + d^2 / 2.

    The remainder of a series is at most its first omitted term. For larger angles the bound is one.
    """
    middle = exactly(x.mid)
    square = middle * middle
    sine, cosine = (
        _horner(square, [(-1.0) ** k / factorial(2 * k + odd) for k in range(_SINE_TERMS)]) for odd in (1, 0)
    )
    sine = sine * middle
    rest = np.full_like(x.rad, 2.0 * _LARGEST_ANGLE ** (2 * _SINE_TERMS) / factorial(2 * _SINE_TERMS))
    near = np.abs(x.mid) <= _LARGEST_ANGLE
    parts = []
    for part, slope in ((sine, cosine), (cosine, sine)):
        spread = total(part.rad, rest, slope.magnitude * x.rad, rest * x.rad, times(0.5 * x.rad, x.rad))
        parts.append(Enclosure(np.where(near, part.mid, 0.0), np.where(near, spread, 1.0)))
    return parts[0], parts[1]


def _horner(x: Enclosure, coefficients: list[float]) -> Enclosure:
    """Evaluate a polynomial whose coefficients have errors of at most two roundings, (1 + u)^2 - 1 < 2^-51."""
    slack = 2.0**-51
    result = exactly(np.zeros_like(x.mid))
    for value in reversed(coefficients):
        result = result * x + Enclosure(np.full_like(x.mid, value), np.full_like(x.mid, abs(value) * slack))
    return result


def expand(coefficients: Enclosure, at: Enclosure, terms: int = TERMS) -> Enclosure:
    """Expand polynomials with coefficients (orders, ..., n) about t = at (n,), to the given number of terms."""
    orders = len(coefficients.mid)
    powers = [exactly(np.ones_like(at.mid))]
    for _ in range(orders - 1):
        powers.append(powers[-1] * at)
    result = []
    for k in range(terms):
        parts = [coefficients[j] * (exactly(float(comb(j, k))) * powers[j - k]) for j in range(k, orders)]
        value = parts[0] if parts else exactly(np.zeros_like(coefficients.mid[0]))
        for part in parts[1:]:
            value = value + part
        result.append(value)
    return stacked(result)
