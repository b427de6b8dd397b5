"""Series for many boxes: sines and cosines, shifted polynomials, splines."""

from fractions import Fraction
from math import factorial

import numpy as np
import pytest
from flint import arb, arb_series, ctx

from pipeline.certify.recheck.arithmetic.enclosure import exactly, within
from pipeline.certify.recheck.arithmetic.jets import TERMS, _horner, expand, sine_cosine


@pytest.mark.parametrize("angle", [-3.9, -1.0, 0.0, 1e-9, 0.7, 3.2])
def test_sine_and_cosine_hold_those_of_ball_arithmetic(angle: float) -> None:
    """Of a series, to all orders."""
    coefficients = [angle, 0.5, -0.25, 0.125, 2.0]
    sine, cosine = sine_cosine(exactly(np.array(coefficients)[:, None]))
    with ctx.workprec(200):
        series = arb_series([arb(c) for c in coefficients], prec=TERMS)
        for found, exact in ((sine, series.sin()), (cosine, series.cos())):
            for n in range(TERMS):
                off = abs(exact[n] - arb(float(found.mid[n, 0])))
                assert off < arb(float(found.rad[n, 0]))
                assert found.rad[n, 0] < 1e-13


@pytest.mark.parametrize("k", range(40))
def test_coefficients_of_the_series_are_enclosed(k: int) -> None:
    """One over a factorial is off by the roundings of the factorial and of the division."""
    found = _horner(exactly(np.zeros(1)), [-1.0 / factorial(k)])
    assert abs(Fraction(-1, factorial(k)) - Fraction(found.mid[0])) <= Fraction(found.rad[0])
    assert found.rad[0] >= 2.0**-51 / factorial(k)


def test_angles_beyond_the_series_are_enclosed_coarsely() -> None:
    """Rather a weak statement than a wrong one."""
    sine, _ = sine_cosine(exactly(np.array([[4.5], [0.0], [0.0], [0.0], [0.0]])))
    assert (sine.mid[0, 0], sine.rad[0, 0]) == (0.0, 1.0)


def test_shifted_polynomials_hold_every_value() -> None:
    """About a whole interval the constant term holds all values of the polynomial on it."""
    random = np.random.default_rng(0)
    coefficients, half = random.normal(size=(6, 3, 4)), np.full(4, 0.3)
    over = expand(exactly(coefficients), within(half))[0]
    for t in np.linspace(-0.3, 0.3, 13):
        value = np.einsum("kin,k->in", coefficients, t ** np.arange(6))
        assert (np.abs(value - over.mid) <= over.rad + 1e-14).all()
