"""Whether all poses of boxes have kappa > K or not the start's sign of det H, as stated in `pipeline.bound.kappa`."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.bound.recheck.taylor import Taylor

_UP = 1.0 + 1e-11
_ROUNDED = 1e-11
"""More than what sums of fewer than 1,000 products are off, relative to the magnitudes they are made of."""


@dataclass(frozen=True, eq=False)
class Linear:
    """Matrices or vectors linear in coordinates t in [-1, 1]: value (n, ...), slopes (6, n, ...), error (n, ...)."""

    value: FloatArray
    slope: FloatArray
    error: FloatArray


def linear(forms: list[list[Taylor]]) -> Linear:
    """Turn Taylor forms into linear ones with floats; (n, columns, rows) for lists of rows."""
    half = forms[0][0].half
    value = np.array([[f.value.mid for f in column] for column in forms])
    slope = np.array([[f.slope.mid * half for f in column] for column in forms])
    error = np.array(
        [[(f.value.rad + (f.slope.rad * half).sum(axis=0) + f.rest) * _UP for f in column] for column in forms]
    )
    return Linear(value.transpose(2, 0, 1), slope.transpose(2, 3, 0, 1), error.transpose(2, 0, 1))


def excluded(columns: Linear, ties: Linear, sign: float, K: float) -> BoolArray:
    """Verify boxes by K S < sigma_max, S the Schur complement in singular vectors of the middle. Shape (n,)."""
    H, G = columns.value.transpose(0, 2, 1), columns.slope.transpose(0, 1, 3, 2)
    with np.errstate(all="ignore"):
        E = np.sqrt((columns.error**2).sum(axis=(1, 2))) * _UP
        usable = np.isfinite(H).all(axis=(1, 2)) & np.isfinite(G).all(axis=(0, 2, 3)) & np.isfinite(E)
    H, G = np.where(usable[:, None, None], H, 0.0), np.where(usable[:, None, None], G, 0.0)
    error = np.where(usable[:, None, None], columns.error, 0.0).transpose(0, 2, 1)
    U, s, Vt = np.linalg.svd(H)
    V = Vt.transpose(0, 2, 1)
    turn = np.linalg.det(U @ Vt)
    usable &= (np.abs(np.abs(turn) - 1.0) < 1e-6) & (s[:, 4] > 1e-6)
    for M in (U, V):
        usable &= np.abs(M.transpose(0, 2, 1) @ M - np.eye(6)).sum(axis=(1, 2)) < 1e-12
    s = np.maximum(s, 1e-6 * (np.arange(6) < 5))
    scale = 1.0 / np.sqrt(s[:, :5])
    M = U.transpose(0, 2, 1) @ G @ V
    size = np.sqrt((H**2).sum(axis=(1, 2))) + np.sqrt((G**2).sum(axis=(2, 3))).sum(axis=0) + E
    off = np.abs(U).transpose(0, 2, 1) @ error @ np.abs(V) * _UP + (_ROUNDED * size)[:, None, None]
    # A (5 x 5) scaled to the identity at the middle.
    A = (np.abs(M[:, :, :5, :5]).sum(axis=0) + off[:, :5, :5]) * scale[:, :, None] * scale[:, None, :]
    beta = np.sqrt((A**2).sum(axis=(1, 2))) * _UP
    z = -M[:, :, :5, 5] / s[:, :5]
    zs = np.abs(z).sum(axis=0)
    row = M[:, :, 5, :5]
    r = (A @ (zs / scale)[..., None])[..., 0] + (off[:, :5, 5] + _ROUNDED * size[:, None] * (1.0 + zs)) * scale
    c = (np.abs(row).sum(axis=0) + off[:, 5, :5]) * scale
    third = np.sqrt((r**2).sum(axis=1) * (c**2).sum(axis=1)) / np.where(beta < 1.0, 1.0 - beta, 1.0)
    products = np.einsum("knj,mnj->nkm", row, z)
    signed = np.where(turn * sign > 0.0, 1.0, -1.0)
    symmetric = 0.5 * (products + products.transpose(0, 2, 1)) * signed[:, None, None]
    squares = np.einsum("nkk->nk", symmetric)
    curved = np.abs(symmetric).sum(axis=(1, 2)) - np.abs(squares).sum(axis=1) + np.maximum(squares, 0.0).sum(axis=1)
    missed = off[:, 5, 5] + (off[:, 5, :5] * zs).sum(axis=1)
    above = (curved + third + missed) * _UP + _ROUNDED * size * (1.0 + zs.sum(axis=1))
    slopes = K * signed * M[:, :, 5, 5] - M[:, :, 0, 0]
    value = K * (signed * s[:, 5] + above) - s[:, 0] + off[:, 0, 0]
    found = _least_on_ties(slopes, ties) + value + _ROUNDED * (K + 1.0) * size
    return np.asarray(usable & (beta < 1.0) & (found < 0.0))


def _least_on_ties(slopes: FloatArray, ties: Linear) -> FloatArray:
    """Bound sum slopes t from above where the ties vanish: with multipliers from least squares, or none."""
    T, values, errors = ties.slope[:, :, 0], ties.value[:, 0], ties.error[:, 0]
    by_box = T.transpose(1, 0, 2)
    multipliers = -(np.linalg.pinv(by_box) @ slopes.T[..., None])[..., 0]
    best = np.abs(slopes).sum(axis=0)
    for keep in ((1.0, 1.0), (1.0, 0.0), (0.0, 1.0)):
        m = multipliers * keep
        tied = np.abs(slopes + (T * m).sum(axis=2)).sum(axis=0)
        total = tied + (m * values).sum(axis=1) + (np.abs(m) * errors).sum(axis=1)
        size = np.abs(slopes).sum(axis=0) + (np.abs(m) * (np.abs(T).sum(axis=0) + np.abs(values) + errors)).sum(axis=1)
        best = np.minimum(best, total + _ROUNDED * size)
    return np.asarray(best)
