"""Splines for many boxes: Taylor coefficients, and intervals between knots."""

import numpy as np
import pytest
from scipy.interpolate import BSpline, make_interp_spline

from pipeline.certify.recheck.arithmetic.enclosure import Enclosure
from pipeline.certify.recheck.arithmetic.splines import on_one_piece, spline_taylor
from pipeline.inclusion.pieces import pieces
from tests.certify.paths import knotted


@pytest.mark.parametrize("degree", [1, 5])
def test_splines_agree_with_rational_arithmetic(degree: int) -> None:
    """Taylor coefficients about the middle of every piece, with knots that are not evenly spaced."""
    s = np.linspace(0.0, 1.0, 12) ** 1.5
    spline: BSpline = make_interp_spline(s, np.sin(3.0 * s[:, None] + np.arange(5)), k=degree)
    parts = pieces(spline)
    first, last = np.array([part.first for part in parts]), np.array([part.last for part in parts])
    centre = (first + last) / 2.0
    taylor = spline_taylor(spline.t, spline.c, degree, first, centre)
    for n, part in enumerate(parts):
        for k, exact in enumerate(part.taylor(float(centre[n]))):
            for order, value in enumerate(exact):
                found = Enclosure(taylor.mid[order, k, n], taylor.rad[order, k, n])
                assert abs(int(value.p) / int(value.q) - found.mid) <= found.rad + 1e-16 * abs(found.mid)
                np.testing.assert_allclose(
                    found.mid, spline(centre[n], nu=order)[k] / [1, 1, 2, 6, 24, 120][order], rtol=1e-8, atol=1e-8
                )


def test_intervals_end_at_knots() -> None:
    """An interval may begin and end at a knot, and be a single s, but hold none."""
    spline = knotted(3, 2)
    first, last = np.array([0.0, 0.5, 0.5, 0.4, 0.0]), np.array([0.5, 1.0, 0.5, 0.6, 1.0])
    assert on_one_piece(spline, first, last).tolist() == [True, True, True, False, False]
