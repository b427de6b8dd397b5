"""Whether all poses of boxes have kappa > K or not the start's sign of det H, as stated in `pipeline.bound.kappa`."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.bound.recheck.taylor import Taylor, one_sided

_UP = 1.0 + 1e-11
_ROUNDED = 1e-11
"""More than what sums of fewer than 1,000 products are off, relative to the magnitudes they are made of."""


def excluded(H: Taylor, ties: Taylor, sign: float, K: float) -> BoolArray:
    """Verify boxes by their H (6 rows, 6 links, n) and functions (2, n) that vanish at all poses. Shape (n,)."""
    with np.errstate(all="ignore"):
        at = _rotate(H)
        r = _residual(at)
        side = np.where(at.turn * sign > 0.0, 1.0, -1.0)
        largest = at.sigma[:, 0], at.slope[:, :, 0, 0], at.t_bend
        spread = np.abs(largest[1]).sum(axis=0) + one_sided(-largest[2])
        t = largest[0] - (spread + at.t_off) * _UP - _ROUNDED * at.size
        found = []
        for way in (side, -side):
            value = K * way * at.sigma[:, 5] - largest[0] + K * r.off + at.t_off
            slope = K * way * at.slope[:, :, 5, 5] - largest[1]
            bend = K * way * r.bend[..., 5] - largest[2]
            found.append(_least_on_ties(slope, bend, ties) + value + _ROUNDED * (K + 1.0) * at.size * r.long)
        toward, away = found
        # Where |r| is at most K^-1 sqrt(t^2 - ...), the first five entries of r cost this much.
        root = np.sqrt(t**2 / _UP - (K * r.rest * _UP) ** 2)
        cost = np.where((t > 0.0) & np.isfinite(root), t - root, np.inf)
        signed = r.regular & (toward + K * r.corner * _UP < 0.0)
        near = r.regular & (toward + cost < 0.0) & (K * np.hypot(r.rest, r.corner) * _UP < t)
        either = (toward + cost < 0.0) & (away + cost < 0.0)
        return np.asarray(at.usable & (signed | near | either))


@dataclass(frozen=True, eq=False)
class _Rotated:
    """U' H V of boxes: sigma (n, 6) in the middle, slope (N, n, 6, 6), and `off`, all changes of second order or more.

    turn is det U det V (n,). Of the last column: bend (N, N, n, 6), and the rest (n, 6). t is u_1' H v_1.
    """

    sigma: FloatArray
    turn: FloatArray
    slope: FloatArray
    column: FloatArray
    column_off: FloatArray
    t_bend: FloatArray
    t_off: FloatArray
    off: FloatArray
    size: FloatArray
    usable: BoolArray


def _rotate(H: Taylor) -> _Rotated:
    middle, slope = np.moveaxis(H.value, -1, 0), np.moveaxis(H.slope, -1, 1)
    size = np.sqrt((H.mass**2).sum(axis=(0, 1)))
    usable = np.isfinite(H.slope).all(axis=(0, 1, 2)) & np.isfinite(size) & np.isfinite(H.bend).all(axis=(0, 1, 2, 3))
    middle = np.where(usable[:, None, None], middle, 0.0)
    slope = np.where(usable[:, None, None], slope, 0.0)
    U, sigma, Vt = np.linalg.svd(np.ascontiguousarray(middle))
    V, Ut = Vt.transpose(0, 2, 1), U.transpose(0, 2, 1)
    turn = np.linalg.det(U @ Vt)
    usable &= np.abs(np.abs(turn) - 1.0) < 1e-6
    for M in (U, V):
        usable &= np.abs(M.transpose(0, 2, 1) @ M - np.eye(6)).sum(axis=(1, 2)) < 1e-12
    u, v = np.ascontiguousarray(U.transpose(1, 2, 0)), np.ascontiguousarray(V.transpose(1, 2, 0))
    bent = np.einsum("abrcn,cn->abrn", H.bend, v[:, 5])
    column = np.moveaxis(np.einsum("rsn,abrn->absn", u, bent), -1, 2)
    t_bend = np.einsum("rn,abrn->abn", u[:, 0], np.einsum("abrcn,cn->abrn", H.bend, v[:, 0]))
    aU, aV = np.abs(Ut), np.abs(V)
    rest = np.moveaxis(H.rest, -1, 0)
    changed = np.moveaxis(H.rest + np.abs(H.bend).sum(axis=(0, 1)), -1, 0)
    rounding = _ROUNDED * size[:, None]
    return _Rotated(
        sigma,
        turn,
        Ut @ slope @ V,
        column,
        (aU @ rest @ aV[:, :, 5:])[..., 0] * _UP + rounding,
        t_bend,
        (aU[:, :1] @ rest @ aV[:, :, :1])[:, 0, 0] * _UP + rounding[:, 0],
        aU @ changed @ aV * _UP + rounding[..., None],
        size,
        usable,
    )


@dataclass(frozen=True, eq=False)
class _Residual:
    """r = U' H V (z, 1): its bend (N, N, n, 6), error of r_6 (n,), bounds (n,) of r_(1..5) and of c' A^-1 r_(1..5)."""

    bend: FloatArray
    off: FloatArray
    rest: FloatArray
    corner: FloatArray
    regular: BoolArray
    long: FloatArray


def _residual(at: _Rotated) -> _Residual:
    divisors = np.maximum(at.sigma[:, :5], 1e-6)
    z = -at.slope[:, :, :5, 5] / divisors
    zs = np.abs(z).sum(axis=0)
    bend = np.einsum("knij,mnj->kmni", at.slope[..., :5], z) + at.column
    left_over = np.abs(at.slope[:, :, :5, 5] + at.sigma[:, :5] * z).sum(axis=0)
    off = (at.column_off + (at.off[:, :, :5] @ zs[..., None])[..., 0]) * _UP
    # t_k^2 is 1/2 and an error of 1/2.
    squares = np.stack([bend[k, k, :, :5] for k in range(len(bend))])
    pairs = 0.5 * np.abs(bend + bend.swapaxes(0, 1))[..., :5].sum(axis=(0, 1)) - np.abs(squares).sum(axis=0)
    first = pairs + 0.5 * (np.abs(squares).sum(axis=0) + np.abs(squares.sum(axis=0))) + left_over + off[:, :5]
    scale = 1.0 / np.sqrt(divisors)
    A = (np.abs(at.slope[:, :, :5, :5]).sum(axis=0) + at.off[:, :5, :5]) * scale[:, :, None] * scale[:, None]
    c = (np.abs(at.slope[:, :, 5, :5]).sum(axis=0) + at.off[:, 5, :5]) * scale
    beta = np.sqrt((A**2).sum(axis=(1, 2))) * _UP
    regular = (beta < 1.0) & (at.sigma[:, 4] > 1e-6)
    corner = np.sqrt((c**2).sum(axis=1) * ((first * scale) ** 2).sum(axis=1)) / (1.0 - beta)
    long = 1.0 + zs.sum(axis=1)
    slack = _ROUNDED * at.size * long
    rest = np.sqrt((first**2).sum(axis=1)) * _UP + slack
    return _Residual(bend, off[:, 5] + slack, rest, corner * _UP + slack * scale[:, 4], regular, long)


def _least_on_ties(slope: FloatArray, bend: FloatArray, ties: Taylor) -> FloatArray:
    """Bound slope . t + t' bend t where the ties vanish: with multipliers from least squares, or some of them."""
    T = ties.slope
    by_box = T.transpose(2, 0, 1)
    gram = by_box.transpose(0, 2, 1) @ by_box + 1e-12 * np.eye(2)
    multipliers = -np.linalg.solve(gram, by_box.transpose(0, 2, 1) @ slope.T[..., None])[..., 0].T
    best = np.abs(slope).sum(axis=0) + one_sided(bend)
    for keep in ((1.0, 1.0), (1.0, 0.0), (0.0, 1.0)):
        m = multipliers * np.array(keep)[:, None]
        straight = slope + np.einsum("an,kan->kn", m, T)
        curved = bend + np.einsum("an,kman->kmn", m, ties.bend)
        total = np.abs(straight).sum(axis=0) + one_sided(curved)
        total = total + (m * ties.value).sum(axis=0) + (np.abs(m) * ties.rest).sum(axis=0)
        size = np.abs(slope).sum(axis=0) + np.abs(bend).sum(axis=(0, 1)) + (np.abs(m) * ties.mass).sum(axis=0)
        best = np.minimum(best, total + _ROUNDED * size)
    return np.asarray(best)
