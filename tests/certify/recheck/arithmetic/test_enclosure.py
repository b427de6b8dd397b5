"""Intervals in floats: every operation holds what exact arithmetic gives."""

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, contract, cross, dot, exactly, root, total

NUMBERS = st.floats(-1e6, 1e6, allow_nan=False).filter(lambda x: x == 0.0 or abs(x) > 1e-100)
VECTORS = st.lists(NUMBERS, min_size=3, max_size=3)
OPERATIONS: dict[str, Callable[..., object]] = {
    "sum": lambda a, b: a + b,
    "difference": lambda a, b: a - b,
    "product": lambda a, b: a * b,
}


def holds(enclosure: Enclosure, exact: Fraction, index: tuple[int, ...] = ()) -> bool:
    """Tell whether an exact number is within an enclosure, in rational arithmetic."""
    return abs(exact - Fraction(float(enclosure.mid[index]))) <= Fraction(float(enclosure.rad[index]))


@pytest.mark.parametrize("name", OPERATIONS)
@given(a=NUMBERS, b=NUMBERS)
def test_operations_on_numbers(name: str, a: float, b: float) -> None:
    """The exact result is inside, however it is rounded."""
    operation = OPERATIONS[name]
    result, exact = operation(exactly(a), exactly(b)), operation(Fraction(a), Fraction(b))
    assert holds(result, exact)


@given(a=NUMBERS, b=NUMBERS, r=st.floats(0.0, 10.0), u=st.floats(-1.0, 1.0), v=st.floats(-1.0, 1.0))
def test_products_of_intervals(a: float, b: float, r: float, u: float, v: float) -> None:
    """Any two members of two intervals have their product inside."""
    x, y = Enclosure(np.array(a), np.array(r)), Enclosure(np.array(b), np.array(r / 2.0))
    member = (Fraction(a) + Fraction(u) * Fraction(r), Fraction(b) + Fraction(v) * Fraction(r) / 2)
    assert holds(x * y, member[0] * member[1])


@given(a=NUMBERS.filter(lambda x: abs(x) > 1e-3), r=st.floats(0.0, 2.0), u=st.floats(-1.0, 1.0))
def test_inverses(a: float, r: float, u: float) -> None:
    """An interval that may be zero has no inverse, any other holds the inverses of its members."""
    inverse = Enclosure(np.array(a), np.array(r)).inverse()
    if np.isfinite(inverse.rad):
        assert holds(inverse, 1 / (Fraction(a) + Fraction(u) * Fraction(r)))
    else:
        assert r >= abs(a) * (1.0 - 1e-12)


@given(a=VECTORS, b=VECTORS)
def test_products_of_vectors(a: list[float], b: list[float]) -> None:
    """Scalar and vector products, and sums of products by einsum."""
    x, y = exactly(a), exactly(b)
    A, B = [Fraction(v) for v in a], [Fraction(v) for v in b]
    inner = sum(p * q for p, q in zip(A, B, strict=True))
    assert holds(dot(x, y, 0), inner)
    assert holds(contract("i,i->", x, y, 3), inner)
    product = cross(x, y, 0)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        assert holds(product, A[j] * B[k] - A[k] * B[j], (i,))


@given(st.lists(st.floats(0.0, 1e6), min_size=2, max_size=6))
def test_bounds_are_rounded_up(values: list[float]) -> None:
    """Sums and roots of bounds are bounds."""
    parts = [np.array(value) for value in values]
    assert Fraction(float(total(*parts))) >= sum(Fraction(value) for value in values)
    assert Fraction(float(root(parts[0]))) ** 2 >= Fraction(values[0])
