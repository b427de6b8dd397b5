"""Tests of quadratic forms: what they stand for is never outside."""

import numpy as np
import pytest
from flint import arb

from pipeline.bound.forms import (
    Form,
    constant,
    coordinate,
    cosine_sine,
    cross,
    inverse_root,
    joined,
    linear,
    pairs,
    sum_of,
)

BOXES = 300


def _values(form: Form, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bounds of a form at given coordinates (N, n)."""
    i, j = pairs(len(x))
    middle = form.c + (form.g * x).sum(axis=0) + (form.q * x[i] * x[j]).sum(axis=0)
    return middle - form.e - 1e-14, middle + form.e + 1e-14


@pytest.fixture
def drawn() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Draw middles and half widths of three coordinates, and where in their boxes (3, n)."""
    rng = np.random.default_rng(5)
    return (
        rng.uniform(-2.0, 2.0, (3, BOXES)),
        10.0 ** rng.uniform(-6.0, 0.0, (3, BOXES)),
        rng.uniform(-1, 1, (3, BOXES)),
    )


def test_an_expression_is_enclosed(drawn: tuple[np.ndarray, np.ndarray, np.ndarray]):
    """Sums, products, sines and inverse roots hold the true value at every point of the box."""
    middle, half, x = drawn
    p, q, r = (coordinate(middle[k], half[k], k, 3) for k in range(3))
    cosine, sine = cosine_sine(middle[2], half[2], 2, 3)
    form = p * q - (q * q).times(0.5) + cosine * p - sine.plus(0.25) * r
    a, b, c = middle + half * x
    true = a * b - 0.5 * b * b + np.cos(c) * a - (np.sin(c) + 0.25) * c
    low, high = _values(form, x)
    assert (low <= true).all()
    assert (true <= high).all()
    assert (form.lower <= true).all()
    assert (true <= form.upper).all()


def test_inverse_roots_hold_where_they_are_wanted(drawn: tuple[np.ndarray, np.ndarray, np.ndarray]):
    """Values outside the wanted range are no matter; those inside are enclosed."""
    middle, half, x = drawn
    square = coordinate(middle[0] + 1.0, half[0], 0, 3)
    root = inverse_root(square, 0.5, 2.0)
    value = middle[0] + 1.0 + half[0] * x[0]
    wanted = (value >= 0.5) & (value <= 2.0)
    low, high = _values(root, x)
    assert wanted.sum() > 30
    assert (low[wanted] <= 1.0 / np.sqrt(value[wanted])).all()
    assert (1.0 / np.sqrt(value[wanted]) <= high[wanted]).all()


def test_errors_are_of_third_order():
    """Halving a box leaves an eighth of what is not quadratic."""
    errors = []
    for half in (0.02, 0.01):
        p, q = (coordinate(np.array([0.7]), np.array([half]), k, 2) for k in range(2))
        cosine, sine = cosine_sine(np.array([0.4]), np.array([half]), 1, 2)
        errors.append(float((inverse_root((p * q).plus(1.0), 0.5, 2.0) * (p * sine - cosine)).e[0]))
    assert errors[1] == pytest.approx(errors[0] / 8.0, rel=0.05)


def test_squares_count_to_one_side_only():
    """A square is no less than zero, and a bound of its negative no more; mixed products count to both sides."""
    p, q = (linear(np.zeros(1), np.eye(2)[:, k, None]) for k in range(2))
    square, mixed = p * p, p * q
    assert (square.lower[0], square.upper[0]) == pytest.approx((0.0, 1.0), abs=1e-12)
    assert (mixed.lower[0], mixed.upper[0]) == pytest.approx((-1.0, 1.0), abs=1e-12)


def test_cross_products_are_those_of_the_vectors():
    """Of constants, that of numpy."""
    a, b = np.random.default_rng(1).normal(size=(2, 4, 3, 5))
    found = cross(constant(a, 2), constant(b, 2))
    assert found.c == pytest.approx(np.cross(a, b, axis=1))
    assert found.g.shape == (2, 4, 3, 5)


def test_sines_of_the_library_are_as_good_as_assumed():
    """Against balls of 100 bits sine and cosine of floats are off by less than the slack, all over the chart."""
    angles = np.random.default_rng(0).uniform(-7.0, 7.0, 500)
    zero = np.zeros(500)
    cosine, sine = cosine_sine(angles, zero, None, 1)
    for k, angle in enumerate(angles.tolist()):
        assert abs(float(arb(angle).cos()) - cosine.c[k]) < cosine.e[k]
        assert abs(float(arb(angle).sin()) - sine.c[k]) < sine.e[k]


def test_forms_are_stacked_and_summed():
    """A stack is indexed back into its parts; sums are those of the parts."""
    parts = [constant(np.full(2, float(k)), 1, 0.5) for k in range(3)]
    assert joined(parts)[1].c.tolist() == [1.0, 1.0]
    assert sum_of(parts).c.tolist() == [3.0, 3.0]
    assert (sum_of(parts).radius >= 1.5).all()
