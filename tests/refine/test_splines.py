"""Splines in actuator space."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from pipeline.refine.splines import DEGREE, basis, clamped_knots, fit


@given(coefficients=st.integers(8, 60), s=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20))
def test_the_basis_is_a_partition_of_unity(coefficients: int, s: list[float]) -> None:
    """Basis functions are not negative and add up to one: a spline stays in the hull of its coefficients."""
    values = basis(clamped_knots(coefficients), np.array(s)).toarray()
    assert values.min() >= 0.0
    np.testing.assert_allclose(values.sum(axis=1), 1.0, atol=1e-12)


def test_a_clamped_spline_begins_and_ends_at_its_outer_coefficients() -> None:
    """Start and goal are single coefficients."""
    values = basis(clamped_knots(12), np.array([0.0, 1.0])).toarray()
    np.testing.assert_array_equal(values, np.eye(12)[[0, -1]])


@pytest.mark.parametrize("power", range(DEGREE + 1))
def test_a_fit_reproduces_polynomials_up_to_its_degree(power: int) -> None:
    """What a quintic spline can represent exactly is fitted exactly."""
    s, knots = np.linspace(0.0, 1.0, 200), clamped_knots(15)
    q = np.repeat((s**power)[:, None], 5, axis=1)
    np.testing.assert_allclose(BSpline(knots, fit(knots, s, q), DEGREE)(s), q, atol=1e-10)


def test_the_fit_of_a_smooth_curve_converges_with_order_six() -> None:
    """Halving the knots' distance divides the error by about 2^6."""
    s = np.linspace(0.0, 1.0, 4_001)
    q = np.repeat(np.sin(7.0 * s)[:, None], 5, axis=1)
    errors = []
    for intervals in (8, 16, 32):
        knots = clamped_knots(intervals + DEGREE)
        errors.append(np.abs(BSpline(knots, fit(knots, s, q), DEGREE)(s) - q).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 5.0).all(), orders
