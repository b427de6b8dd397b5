"""Signs of determinants of matrices of floats, exactly: a float is an integer over a power of two.

Intervals decide most of them, all matrices at a time; whole numbers decide the others, one by one.
"""

from itertools import combinations

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, exactly


def det_signs(matrices: FloatArray) -> FloatArray:
    """Compute the signs -1, 0 or 1 of determinants of matrices (m, m, n), 0 if entries are not finite. Shape (n,)."""
    with np.errstate(all="ignore"):
        det = _determinants(exactly(matrices))
        signs = np.where(det.lower > 0.0, 1.0, np.where(det.upper < 0.0, -1.0, 0.0))
    finite = np.isfinite(matrices).all(axis=(0, 1))
    for k in np.flatnonzero((signs == 0.0) & finite):
        signs[k] = _sign(matrices[..., k].tolist())
    return np.where(finite, signs, 0.0)


def _determinants(M: Enclosure) -> Enclosure:
    """Expand determinants (n,) by rows: each minor of the first rows is a sum over its last row."""
    m = len(M.mid)
    minors: dict[tuple[int, ...], Enclosure] = {(): exactly(np.ones_like(M.mid[0, 0]))}
    for row in range(m):
        above, minors = minors, {}
        for columns in combinations(range(m), row + 1):
            total = exactly(np.zeros_like(M.mid[0, 0]))
            for place, column in enumerate(columns):
                term = M[row, column] * above[columns[:place] + columns[place + 1 :]]
                total = total + (term if (row + place) % 2 == 0 else -term)
            minors[columns] = total
    return minors[tuple(range(m))]


def _sign(rows: list[list[float]]) -> int:
    """Eliminate in integers (Bareiss, 1968): no division leaves a remainder."""
    ratios = [[value.as_integer_ratio() for value in row] for row in rows]
    common = max(below for row in ratios for _, below in row)
    A = [[above * (common // below) for above, below in row] for row in ratios]
    sign, last = 1, 1
    for k in range(len(A)):
        pivot = next((i for i in range(k, len(A)) if A[i][k]), None)
        if pivot is None:
            return 0
        if pivot != k:
            A[k], A[pivot], sign = A[pivot], A[k], -sign
        for i in range(k + 1, len(A)):
            A[i][k:] = [(A[k][k] * a - A[i][k] * b) // last for a, b in zip(A[i][k:], A[k][k:], strict=True)]
        last = A[k][k]
    return sign if last > 0 else -sign
