"""Signs of determinants of matrices of floats, exactly: a float is an integer over a power of two."""

import numpy as np

from pipeline.arrays import FloatArray


def det_signs(matrices: FloatArray) -> FloatArray:
    """Compute the signs -1, 0 or 1 of determinants of matrices (m, m, n), 0 if entries are not finite. Shape (n,)."""
    stack = np.moveaxis(matrices, -1, 0)
    return np.array([float(_sign(M.tolist())) if np.isfinite(M).all() else 0.0 for M in stack])


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
