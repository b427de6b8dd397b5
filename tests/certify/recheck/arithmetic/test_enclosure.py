"""Intervals in floats: every operation holds what exact arithmetic gives, over the whole range of floats."""

from collections.abc import Callable, Iterator
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pipeline.certify.recheck.arithmetic.enclosure import (
    Enclosure,
    bound,
    contract,
    cross,
    dot,
    exactly,
    root,
    rounded_down,
    times,
    total,
    within,
)

LARGEST, LEAST = np.finfo(float).max, 5e-324
EDGES = [0.0, LEAST, 2.0**-1022, 1e-160, 1e-145, 1.0, 1e140, 1e154, 1e160, LARGEST]
SIZES = st.sampled_from(EDGES) | st.floats(0.0, LARGEST)
NUMBERS = SIZES | SIZES.map(lambda x: -x)
PARTS = st.sampled_from([-1.0, 1.0, 0.0]) | st.floats(-1.0, 1.0)
VECTORS = st.lists(NUMBERS, min_size=3, max_size=3)
OPERATIONS: dict[str, Callable[..., object]] = {
    "sum": lambda a, b: a + b,
    "difference": lambda a, b: a - b,
    "product": lambda a, b: a * b,
}


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    """Let numbers overflow and underflow: that is what is tested."""
    with np.errstate(all="ignore"):
        yield


def interval(mid: float, rad: float) -> Enclosure:
    """Make one interval."""
    return Enclosure(np.array(mid), np.array(rad))


def member(mid: float, rad: float, part: float) -> Fraction:
    """Take a member of an interval: the middle plus a part of the radius, exactly."""
    return Fraction(mid) + Fraction(part) * Fraction(rad)


def holds(enclosure: Enclosure, exact: Fraction, index: tuple[int, ...] = ()) -> bool:
    """Tell whether an exact number is within an enclosure, in rational arithmetic."""
    mid, rad = float(enclosure.mid[index]), float(enclosure.rad[index])
    if not (np.isfinite(mid) and np.isfinite(rad)):
        return True
    lower, upper = float(enclosure.lower[index]), float(enclosure.upper[index])
    outside = (np.isfinite(lower) and exact < Fraction(lower)) or (np.isfinite(upper) and exact > Fraction(upper))
    return abs(exact - Fraction(mid)) <= Fraction(rad) and not outside


def above(value: np.floating, exact: Fraction) -> bool:
    """Tell whether a float is an upper bound; infinity and NaN, which compares as false, bound everything."""
    return not np.isfinite(value) or Fraction(float(value)) >= exact


@pytest.mark.parametrize("name", OPERATIONS)
@given(a=NUMBERS, r=SIZES, u=PARTS, b=NUMBERS, t=SIZES, v=PARTS)
def test_operations_on_intervals(name: str, a: float, r: float, u: float, b: float, t: float, v: float) -> None:
    """Any two members of two intervals have their result inside, however it is rounded."""
    operation = OPERATIONS[name]
    for r_, t_ in ((r, t), (0.0, 0.0), (r, 0.0)):
        result = operation(interval(a, r_), interval(b, t_))
        assert isinstance(result, Enclosure)
        exact = operation(member(a, r_, u), member(b, t_, v))
        assert isinstance(exact, Fraction)
        assert holds(result, exact)


@given(a=NUMBERS, r=SIZES, u=PARTS)
@example(a=1e-150, r=1e-160, u=1.0)
@example(a=1e200, r=1e199, u=-1.0)
@example(a=1e-160, r=LEAST, u=-1.0)
@example(a=LEAST, r=0.0, u=0.0)
@example(a=-LARGEST, r=LARGEST, u=1.0)
def test_inverses(a: float, r: float, u: float) -> None:
    """An interval that may be zero has no inverse, any other holds the inverses of its members."""
    for r_ in (r, 0.0, min(r, abs(a) / 2.0)):
        inverse = interval(a, r_).inverse()
        if np.isfinite(inverse.rad):
            assert holds(inverse, 1 / member(a, r_, u))
        else:
            assert r_ >= abs(a) * (1.0 - 1e-12) or abs(a) < 1e-300


@given(a=st.floats(1e-140, 1e140), r=st.floats(0.0, 0.5))
def test_inverses_are_sharp(a: float, r: float) -> None:
    """The radius is what it has to be, up to rounding: an infinite one would be right, too."""
    inverse = interval(a, r * a).inverse()
    assert inverse.rad <= r / (1.0 - r) / a * (1.0 + 1e-12) + 1e-15 / a + 1e-289


@given(a=st.sampled_from([np.inf, -np.inf, np.nan]), b=NUMBERS | st.sampled_from([np.inf, -np.inf, np.nan]))
def test_what_is_not_finite_may_be_any_number(a: float, b: float) -> None:
    """An overflow never becomes a statement about a number."""
    x, y = exactly(a), exactly(b)
    for result in (x, x + y, x - y, x * y, y * x, x.inverse(), x * exactly(0.0)):
        assert not (np.isfinite(result.mid) and np.isfinite(result.rad))
        assert not result.lower > -LARGEST
        assert not result.upper < LARGEST
        assert not result.magnitude < LARGEST


@given(a=VECTORS, b=VECTORS, r=SIZES, u=PARTS)
def test_products_of_vectors(a: list[float], b: list[float], r: float, u: float) -> None:
    """Scalar and vector products, and sums of products by einsum, of vectors and of intervals about them."""
    for r_ in (0.0, r):
        x, y = Enclosure(np.array(a), np.full(3, r_)), exactly(b)
        A, B = [member(v, r_, u) for v in a], [Fraction(v) for v in b]
        inner = sum((p * q for p, q in zip(A, B, strict=True)), Fraction(0))
        assert holds(dot(x, y, 0), inner)
        assert holds(contract("i,i->", x, y, 3), inner)
        product = cross(x, y, 0)
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            assert holds(product, A[j] * B[k] - A[k] * B[j], (i,))


@given(st.lists(SIZES, min_size=2, max_size=6))
def test_bounds_are_rounded_up(values: list[float]) -> None:
    """Sums, products, roots and sums of products of bounds are bounds."""
    parts, exact = [np.array(value) for value in values], [Fraction(value) for value in values]
    product = Fraction(1)
    for value in exact:
        product *= value
    assert above(total(*parts), sum(exact, Fraction(0)))
    assert above(times(*parts), product)
    assert not np.isfinite(root(parts[0])) or Fraction(float(root(parts[0]))) ** 2 >= exact[0]
    squares = sum((value * value for value in exact), Fraction(0))
    assert above(bound("i,i->", np.array(values), np.array(values), len(values)), squares)
    assert above(within(parts[0]).magnitude, exact[0])


@given(a=SIZES, b=SIZES.filter(lambda x: x > 0.0))
def test_quotients_are_rounded_down(a: float, b: float) -> None:
    """A quotient of positive numbers that is to be a bound from below is one."""
    quotient = float(rounded_down(np.array(a) / np.array(b), 1))
    assert not np.isfinite(quotient) or Fraction(quotient) <= Fraction(a) / Fraction(b)
