"""Signs of determinants, exactly."""

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pipeline.certify.recheck.arithmetic.determinant import det_signs


def determinant(rows: list[list[Fraction]]) -> Fraction:
    """Expand by the first row."""
    if not rows:
        return Fraction(1)
    minors = ([row[:k] + row[k + 1 :] for row in rows[1:]] for k in range(len(rows)))
    return sum(((-1) ** k * rows[0][k] * determinant(minor) for k, minor in enumerate(minors)), Fraction(0))


@given(
    st.lists(
        st.lists(st.sampled_from([0.0, 1.0, -1.0, 0.1, 1e-200, 3e150]), min_size=4, max_size=4), min_size=4, max_size=4
    )
)
def test_signs_are_those_of_an_expansion_in_fractions(rows: list[list[float]]) -> None:
    """Of zeros where pivots would be, of the tiny and the huge."""
    exact = determinant([[Fraction(value) for value in row] for row in rows])
    assert det_signs(np.array(rows)[..., None]) == [(exact > 0) - (exact < 0)]


def test_a_last_bit_decides() -> None:
    """The square of 2^-27 is below a rounding of one."""
    e = 2.0**-27
    pairs = ([[1.0 + e, 1.0], [1.0, 1.0 - e]], [[1.0, 1.0 - e], [1.0 + e, 1.0]], [[1.0 + e, 1.0 + e], [1.0, 1.0]])
    matrices = np.repeat(np.eye(6)[..., None], 3, axis=-1)
    matrices[:2, :2] = np.moveaxis(np.array(pairs), 0, -1)
    assert det_signs(matrices).tolist() == [-1.0, 1.0, 0.0]


def test_many_at_once() -> None:
    """The last axis counts matrices; what is no number has no sign."""
    random = np.random.default_rng(2).normal(size=(40, 6, 6))
    stack = np.concatenate([random, np.full((1, 6, 6), np.nan), np.full((1, 6, 6), np.inf)])
    expected = [*np.sign(np.linalg.det(random)), 0.0, 0.0]
    assert det_signs(np.moveaxis(stack, 0, -1)).tolist() == expected
