"""TOPP-RA: known fastest profiles, a linear program over the whole grid, all units and ratios, rest that is no rest."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from pipeline.arrays import FloatArray
from pipeline.solvers.topp_ra import fastest_profile

S = np.linspace(0.0, 1.0, 201)
Rows = tuple[FloatArray, FloatArray, FloatArray]


def _rows(b: float = 0.0) -> Rows:
    """|sdd + b sd^2| <= 1 all along the path."""
    a = np.tile([1.0, -1.0], (len(S), 1))
    return a, b * a, np.zeros_like(a)


def _random_rows(seed: int, points: int = 41) -> tuple[FloatArray, Rows, FloatArray]:
    """Rows of smooth curves with accelerations limited on both sides, some of it used up at rest, and caps."""
    rng, s = np.random.default_rng(seed), np.linspace(0.0, 1.0, points)
    phase, waves = rng.uniform(0.0, 2.0 * np.pi, (3, 4)), rng.uniform(0.5, 8.0, (3, 4))
    a, b, c = (np.sin(waves[k] * s[:, None] + phase[k]) * size for k, size in enumerate((1.0, 5.0, 0.6)))
    cap = 10.0 ** rng.uniform(-1.0, 1.0) * (1.5 + np.sin(7.0 * s + phase[0, 0]))
    return s, tuple(np.concatenate([part, -part], axis=1) for part in (a, b, c)), cap


def _exceeded(s: FloatArray, rows: Rows, cap: FloatArray, sd: FloatArray) -> float:
    """The largest excess over any row at either end of any cell, and over any cap."""
    x = sd**2
    u = (np.diff(x) / (2.0 * np.diff(s)))[:, None]
    ends = [
        a * u + b * y[:, None] + c
        for a, b, c, y in ((*(part[:-1] for part in rows), x[:-1]), (*(part[1:] for part in rows), x[1:]))
    ]
    return float(max(np.max(ends) - 1.0, (x / cap**2).max() - 1.0))


@pytest.mark.parametrize("cap", [np.inf, 0.5])
def test_bang_bang_or_trapezoid(cap: float) -> None:
    """With |sdd| <= 1 from rest to rest, sd^2 is 2 s, then 2 (1 - s), or the cap if that is less."""
    expected = np.minimum(np.sqrt(2.0 * np.minimum(S, 1.0 - S)), cap)
    assert fastest_profile(S, _rows(), np.full(len(S), cap)) == pytest.approx(expected, abs=1e-9)


@given(seed=st.integers(0, 10_000))
def test_rows_and_caps_hold_and_nothing_stops_on_the_way(seed: int) -> None:
    """At both ends of every cell, to rounding; at rest at both ends of the path only."""
    s, rows, cap = _random_rows(seed)
    sd = fastest_profile(s, rows, cap)
    assert _exceeded(s, rows, cap, sd) < 1e-9
    assert (sd[0], sd[-1]) == (0.0, 0.0)
    assert np.all(sd[1:-1] > 0.0)


@settings(max_examples=20)
@given(seed=st.integers(0, 10_000))
def test_nothing_is_faster_where_rows_do_not_trade_speeds(seed: int) -> None:
    """The largest sum of x under the same rows, by a linear program over the whole grid, is the sum of this profile."""
    s, (a, b, c), cap = _random_rows(seed)
    a = a + np.sign(a) * 1.0  # a keeps away from zero, so that no row has 0 < a < 2 D b
    n, width = len(s), np.diff(s)
    matrix, limit = [], []
    for k in range(n - 1):
        for end in (k, k + 1):
            for row in range(a.shape[1]):
                line = np.zeros(n)
                line[[k, k + 1]] = np.array([-1.0, 1.0]) * a[end, row] / (2.0 * width[k])
                line[end] += b[end, row]
                matrix.append(line)
                limit.append(1.0 - c[end, row])
    top = np.where((np.arange(n) == 0) | (np.arange(n) == n - 1), 0.0, cap**2)
    found = linprog(-np.ones(n), A_ub=np.array(matrix), b_ub=limit, bounds=np.stack([np.zeros(n), top], axis=1))
    assert (fastest_profile(s, (a, b, c), cap) ** 2).sum() == pytest.approx(-found.fun, rel=1e-6)


@given(seed=st.integers(0, 10_000), exponent=st.integers(-75, 75), slow=st.integers(0, 60))
def test_units_and_ratios_do_not_matter(seed: int, exponent: int, slow: int) -> None:
    """On a clock that is slower by a power of two the profile is the same bit by bit, however low its caps are."""
    s, (a, b, c), cap = _random_rows(seed)
    clock, cap = 2.0**exponent, cap * 0.5**slow
    other = fastest_profile(s, (a / clock**2, b / clock**2, c), cap * clock)
    assert np.array_equal(other, fastest_profile(s, (a, b, c), cap) * clock)


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), row=st.integers(0, 7), factor=st.floats(1.0, 1e6))
def test_more_is_not_slower(seed: int, row: int, factor: float) -> None:
    """Raising one limit, or a cap, does not lengthen the motion, but for what a cell leaves open."""
    s, (a, b, c), cap = _random_rows(seed, 161)

    def duration(rows: Rows, cap: FloatArray) -> float:
        sd = fastest_profile(s, rows, cap)
        return float((2.0 * np.diff(s) / (sd[1:] + sd[:-1])).sum())

    scale = np.ones(a.shape[1])
    scale[row] = 1.0 / factor
    before = duration((a, b, c), cap)
    assert duration((a * scale, b * scale, c * scale), cap) <= before * (1.0 + 1e-3)
    assert duration((a, b, c), cap * factor) <= before * (1.0 + 1e-3)


def test_rest_beyond_a_limit_is_refused() -> None:
    """Rows that no slow motion keeps."""
    a, b, c = _rows()
    with pytest.raises(ValueError, match="rest is not within the limits"):
        fastest_profile(S, (a, b, np.where(np.abs(S - 0.5)[:, None] < 0.05, 2.0, c)), np.full(len(S), np.inf))
