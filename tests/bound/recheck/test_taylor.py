"""Tests of Taylor forms: values at random points lie within value, gradient and rest."""

import numpy as np

from pipeline.bound.recheck.taylor import coordinate, cosine_sine, inverse_root, known
from pipeline.certify.recheck.arithmetic.enclosure import exactly


def test_an_expression_is_enclosed():
    """Products, sines and inverse roots hold the true value all over the box."""
    rng = np.random.default_rng(2)
    n = 400
    middle, half = rng.uniform(-1.5, 1.5, (6, n)), 10.0 ** rng.uniform(-5.0, -0.5, (6, n))
    t = rng.uniform(-1.0, 1.0, (6, n)) * half
    p, q = coordinate(0, middle, half), coordinate(4, middle, half)
    cosine, sine = cosine_sine(2, middle, half)
    square = p * p + q * q + known(exactly(1.0), half)
    form = (p * cosine - q * sine * 0.5) * inverse_root(square, 0.5)
    a, b, c = (middle[k] + t[k] for k in (0, 4, 2))
    true = (a * np.cos(c) - 0.5 * b * np.sin(c)) / np.sqrt(a * a + b * b + 1.0)
    known_rows = np.isfinite(form.rest) & np.isfinite(form.value.rad)
    assert known_rows.sum() > 300
    near = form.value.mid + (form.slope.mid * t).sum(axis=0)
    allowed = form.value.rad + (form.slope.rad * half).sum(axis=0) + form.rest + 1e-13
    assert (np.abs(true - near) <= allowed)[known_rows].all()
    low, high = form.range
    assert ((low - 1e-13 <= true) & (true <= high + 1e-13))[known_rows].all()
