"""Limits of motion by control coefficients."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from pipeline.machine import Machine
from pipeline.refine.splines import DEGREE, clamped_knots
from pipeline.refine.timed.hull import derivative_matrix, hull_fractions, least_motion_s, rate_limits


@pytest.mark.parametrize("order", [1, 2, 3])
def test_coefficients_of_derivatives_are_those_of_scipy(order: int) -> None:
    """They agree with the derivative of a spline on uneven knots."""
    generator = np.random.default_rng(order)
    inner = np.sort(generator.uniform(size=7))
    knots = np.concatenate([np.zeros(DEGREE + 1), inner, np.ones(DEGREE + 1)])
    c = generator.normal(size=(len(knots) - DEGREE - 1, 2))
    expected = BSpline(knots, c, DEGREE).derivative(order)
    found = derivative_matrix(knots, DEGREE, order) @ c
    np.testing.assert_allclose(found, expected.c[: len(found)], rtol=1e-12)


@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(9, 30))
def test_limits_hold_at_every_instant(machine: Machine, seed: int, count: int) -> None:
    """In the shortest time of its coefficients, no spline exceeds a limit at any of 100,000 instants."""
    spline = BSpline(clamped_knots(count), np.random.default_rng(seed).normal(size=(count, 5)), DEGREE)
    motion_s, tau = least_motion_s(machine, spline), np.linspace(0.0, 1.0, 100_001)
    fractions = hull_fractions(machine, spline, motion_s)
    assert max(part.max() for part in fractions.values()) == pytest.approx(1.0)
    for limit in rate_limits(machine):
        used = np.abs(spline(tau, nu=limit.order)).max(axis=0) / motion_s**limit.order / limit.largest
        assert (used <= fractions[limit.name] * (1.0 + 1e-12)).all()


def test_an_actuator_that_must_not_move_limits_no_time(machine: Machine) -> None:
    """Standing still it has no rate, and divides no zero by its limit."""
    locked = replace(machine, velocity_mps=np.array([0.5, 0.5, 0.5, 0.1, 0.0]))
    c = np.zeros((9, 5))
    c[:, 0] = np.linspace(0.0, 1.0, 9)
    spline = BSpline(clamped_knots(9), c, DEGREE)
    assert least_motion_s(locked, spline) == least_motion_s(machine, spline)
