"""Tests of Taylor polynomials: values at random points lie within the polynomial and its rest."""

import numpy as np
import pytest

from pipeline.bound.recheck.taylor import Taylor, coordinate, cosine_sine, inverse_root, known, linear, one_sided, stack


def _expression(middle: np.ndarray, half: np.ndarray) -> tuple[Taylor, Taylor]:
    n = half.shape[1]
    p, q = coordinate(0, middle[0], half[0], 3), coordinate(1, middle[1], half[1], 3)
    cosine, sine = cosine_sine(2, middle[2], half[2], 3)
    square = p * p + q * q + known(np.ones(n), 3)
    return (p * cosine - (q * sine).scaled(0.5).shifted(0.25)) * inverse_root(square, 1.0, 3.0), square


def test_an_expression_is_enclosed():
    """Products, sines and inverse roots hold the true value all over the box, where the root is wanted."""
    rng = np.random.default_rng(2)
    n = 400
    middle, half = rng.uniform(-1.2, 1.2, (3, n)), 10.0 ** rng.uniform(-5.0, -0.5, (3, n))
    middle[2] *= 4.0
    t = rng.uniform(-1.0, 1.0, (3, n))
    form, square = _expression(middle, half)
    a, b, c = middle + t * half
    true = (a * np.cos(c) - 0.5 * b * np.sin(c) - 0.25) / np.sqrt(a * a + b * b + 1.0)
    wanted = a * a + b * b + 1.0 <= 3.0
    assert wanted.sum() > 300
    near = form.value + (form.slope * t).sum(axis=0) + np.einsum("kn,kmn,mn->n", t, form.bend, t)
    assert (np.abs(true - near) <= form.rest + 1e-13)[wanted].all()
    low, high = form.range
    assert ((low - 1e-13 <= true) & (true <= high + 1e-13) & (np.abs(true) <= form.largest + 1e-13))[wanted].all()
    low, high = square.range
    assert ((low - 1e-13 <= a * a + b * b + 1.0) & (a * a + b * b + 1.0 <= high + 1e-13)).all()


def test_the_rest_is_of_third_order():
    """Halving a box leaves an eighth of the rest."""
    middle = np.array([[0.5], [0.3], [0.8]])
    rests = [float(_expression(middle, np.full((3, 1), half))[0].rest[0]) for half in (0.02, 0.01)]
    assert rests[1] == pytest.approx(rests[0] / 8.0, rel=0.05)


def test_squares_count_to_one_side_only():
    """The form t' B t is bounded by its corners for a diagonal, and by magnitudes for mixed terms of any symmetry."""
    assert one_sided(np.diag([2.0, -3.0])[..., None])[0] == 2.0
    assert one_sided(np.array([[0.0, 4.0], [-1.0, 0.0]])[..., None])[0] == 3.0


def test_matrices_are_applied_to_the_first_axis():
    """A stack of linear functions times a matrix is that of the sums."""
    slopes = np.random.default_rng(0).normal(size=(3, 4, 5))
    parts = [linear(np.full(5, float(k)), slopes[k]) for k in range(3)]
    matrix = np.array([[1.0, 2.0, -1.0], [0.0, 0.5, 0.0]])
    found = stack(parts).mapped(matrix)
    assert found.value[:, 0] == pytest.approx(matrix @ [0.0, 1.0, 2.0])
    assert found.slope.transpose(1, 0, 2) == pytest.approx(np.einsum("mk,kin->min", matrix, slopes))
