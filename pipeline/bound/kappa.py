"""Whether no pose of a box has both kappa <= K and the start's sign of det H.

At the centre H = U diag(sigma) V'. With matrices U, V of floats, nearly orthogonal, U' H V has the blocks A (5 x 5), b,
c', d. For any z, also one that follows the box's coordinates, r = U' H V (z, 1) and w = V (z, 1) have H w = U^-T r and
|w| >= 1, up to what U and V miss: sigma_min <= |r|. Where A is regular, det H has the sign of det U det V S with
S = d - c' A^-1 b = r_6 - c' A^-1 r_(1..5); and with z = -A^-1 b instead, sigma_min <= |S|.

With z that of first order, r_(1..5) is of second order and c of first. Let R bound |r_(1..5)|, Q the last term of S,
and T <= sigma_max be linear and quadratic terms of u_1' H v_1. Signs are such that S > 0 for the start's sign of det H.
A box is excluded

    if A is regular and K (r_6 + Q) < T, since then K S < T;
    if A is regular, K sqrt(R^2 + r_6^2) < T where r_6 >= 0, and K sqrt(R^2 + Q^2) < T, since S > 0 has r_6 > -Q;
    if K sqrt(R^2 + r_6^2) < T whatever the sign of r_6.

For T >= t, K sqrt(R^2 + r^2) < T follows from K (r + d) < T with K d = t - sqrt(t^2 - K^2 R^2): all are linear and
quadratic forms in the box's coordinates, to which multiples of D_k - s_k^2 = 0 are added.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.bound.forms import Form, pairs, quadratic_upper

_UP = 1.0 + 1e-11
"""More than all roundings of sums of at most 10,000 products of one sign, relative to them."""
_ROUNDED = 1e-12
"""More than the roundings of any sum here, relative to the sum of its terms' magnitudes: none has over 1,000 terms."""
_ORTHOGONAL = 1e-12
_LEAST_SIGMA = 1e-6
"""Where H has a smaller second least singular value at the centre, A is not taken for regular."""


@dataclass(frozen=True, eq=False)
class KappaTest:
    """What was found of n boxes.

    Attributes
    ----------
    excluded : (n,)
        All over the box kappa > K, or det H is zero or of the other sign.
    middle : (n,)
        kappa at the centre in floats, infinite with the other sign.
    spread : (N, n)
        How much each coordinate contributes to what is not certain.
    """

    excluded: BoolArray
    middle: FloatArray
    spread: FloatArray


def exclude_by_kappa(H: Form, ties: Form, sign: float, K: float) -> KappaTest:
    """Test boxes by their H, columns (6 links, 6 rows, n), and forms (2, n) that vanish at all poses."""
    at = _singular_vectors(H, sign)
    column = _column(H, at)
    upper, lower = (_inequality(H, at, column, side) for side in (1.0, -1.0))
    multipliers = [_multipliers(one, ties, K) for one in (upper, lower)]
    with np.errstate(invalid="ignore", over="ignore"):
        t = upper.t - np.abs(upper.t_by).sum(axis=0) - quadratic_upper(-upper.t_q, len(H.g)) - upper.missed
        # A root loses digits near zero: what is below it is rounded down first.
        inside = t**2 / _UP - (K * column.R * _UP) ** 2
        more = np.where((inside > 0.0) & (t > 0.0), t - np.sqrt(np.maximum(inside, 0.0)), np.inf)
        here, there = (_value(one, ties, m, K) for one, m in zip((upper, lower), multipliers, strict=True))
        excluded = here + K * column.third * _UP < 0.0
        excluded |= (here + more < 0.0) & ((K * np.hypot(column.R, column.third) * _UP < t) | (there + more < 0.0))
    excluded &= at.usable & np.isfinite(upper.above)
    with np.errstate(divide="ignore"):
        middle = np.where(at.signed > 0.0, at.sigma[0] / np.maximum(at.sigma[5], 1e-300), np.inf)
    i, j = pairs(len(H.g))
    curved = np.sqrt((column.quadratic**2).sum(axis=1))
    bent = np.stack([curved[(i == k) | (j == k)].sum(axis=0) for k in range(len(H.g))])
    return KappaTest(excluded, middle, np.abs(_slopes(upper, ties, multipliers[0], K)) + K * bent)


@dataclass(frozen=True, eq=False)
class _SingularVectors:
    """U, V (6, 6, n), sigma (6, n), sign of det H (n,), wanted or not, whether all of it can be used."""

    U: FloatArray
    V: FloatArray
    sigma: FloatArray
    signed: FloatArray
    usable: BoolArray


def _singular_vectors(H: Form, sign: float) -> _SingularVectors:
    U, sigma, Vt = np.linalg.svd(np.ascontiguousarray(H.c.transpose(2, 1, 0)))
    V = Vt.transpose(0, 2, 1)
    orientation = np.linalg.det(U @ Vt) * sign
    skew = [np.abs(M.transpose(0, 2, 1) @ M - np.eye(6)).sum(axis=(1, 2)) for M in (U, V)]
    usable = (np.maximum(*skew) < _ORTHOGONAL) & (np.abs(np.abs(orientation) - 1.0) < 1e-6)
    U, V = (np.ascontiguousarray(M.transpose(1, 2, 0)) for M in (U, V))
    return _SingularVectors(U, V, np.ascontiguousarray(sigma.T), np.where(orientation > 0.0, 1.0, -1.0), usable)


@dataclass(frozen=True, eq=False)
class _Column:
    """r = (0, sigma_6) + linear + quadratic + error: linear (N, n) of r_6, quadratic (pairs, 6, n), error (n,) of r_6.

    R bounds |r_(1..5)|, third |c' A^-1 r_(1..5)|: infinite where A may be singular.
    """

    linear: FloatArray
    quadratic: FloatArray
    error: FloatArray
    rounding: FloatArray
    R: FloatArray
    third: FloatArray


def _column(H: Form, at: _SingularVectors) -> _Column:
    U, V, sigma = at.U, at.V, at.sigma
    i, j = pairs(len(H.g))
    square = i == j
    M = np.einsum("kjln,lmn->kjmn", np.einsum("ijn,klin->kjln", U, H.g), V)
    rounding = _ROUNDED * np.sqrt((H.size**2).sum(axis=(0, 1)))
    bounded = np.maximum(sigma[:5], _LEAST_SIGMA)
    scale = 1.0 / np.sqrt(bounded)
    z = -M[:, :5, 5] / bounded
    left_over = np.abs(M[:, :5, 5] + sigma[:5] * z).sum(axis=0)
    zs = np.abs(z).sum(axis=0)
    products = np.einsum("kjln,mln->kmjn", M[:, :, :5], z)
    second = np.einsum("ijn,pin->pjn", U, np.einsum("plin,ln->pin", H.q, V[:, 5]))
    Q = np.where(square[:, None, None], products[i, j], products[i, j] + products[j, i]) + second
    # x_k^2 in [0, 1] is half of it as a number, and half an error.
    squares = Q[square][:, :5]
    rest = 0.5 * (np.abs(squares.sum(axis=0)) + np.abs(squares).sum(axis=0)) + np.abs(Q[~square][:, :5]).sum(axis=0)
    left, right = np.abs(U), np.abs(V)
    bent = (H.e + np.abs(H.q).sum(axis=0)) * _UP
    changed = np.einsum("ijn,kin->jkn", left, np.einsum("lin,lkn->kin", bent, right[:, :5])) * _UP + rounding
    error = np.einsum("ijn,in->jn", left, np.einsum("lin,ln->in", H.e, right[:, 5])) * _UP + rounding
    error = (error + np.einsum("jkn,kn->jn", changed, zs)) * _UP
    rest = rest + left_over + error[:5]
    A = (np.abs(M[:, :5, :5]).sum(axis=0) + changed[:5]) * scale[:, None] * scale
    c = (np.abs(M[:, 5, :5]).sum(axis=0) + changed[5]) * scale
    beta = np.sqrt((A**2).sum(axis=(0, 1))) * _UP
    regular = (beta < 1.0) & (sigma[4] > _LEAST_SIGMA)
    third = np.sqrt((c**2).sum(axis=0) * ((rest * scale) ** 2).sum(axis=0)) * _UP / np.where(regular, 1.0 - beta, 1.0)
    slack = 4.0 * rounding * (1.0 + zs.sum(axis=0))
    R = np.sqrt((rest**2).sum(axis=0)) * _UP + slack
    return _Column(M[:, 5, 5], Q, error[5] + slack, rounding, R, np.where(regular, third + slack * scale[4], np.inf))


@dataclass(frozen=True, eq=False)
class _Inequality:
    """r_6 <= s + by . x + q . (x x) + above, and sigma_max >= t + t_by . x + t_q . (x x) - missed."""

    s: FloatArray
    by: FloatArray
    q: FloatArray
    above: FloatArray
    t: FloatArray
    t_by: FloatArray
    t_q: FloatArray
    missed: FloatArray


def _inequality(H: Form, at: _SingularVectors, column: _Column, side: float) -> _Inequality:
    """State both sides, of -r_6 if `side` is -1."""
    u, v, sign = at.U[:, 0], at.V[:, 0], side * at.signed
    t_by = np.einsum("in,kin->kn", u, np.einsum("klin,ln->kin", H.g, v))
    t_q = np.einsum("in,pin->pn", u, np.einsum("plin,ln->pin", H.q, v))
    missed = np.einsum("in,in->n", np.abs(u), np.einsum("lin,ln->in", H.e, np.abs(v))) * _UP + 4.0 * column.rounding
    return _Inequality(
        sign * at.sigma[5],
        sign * column.linear,
        sign * column.quadratic[:, 5],
        column.error,
        at.sigma[0],
        t_by,
        t_q,
        missed,
    )


def _slopes(one: _Inequality, ties: Form, multipliers: FloatArray, K: float) -> FloatArray:
    return np.asarray(K * one.by - one.t_by + np.einsum("an,kan->kn", multipliers, ties.g))


def _multipliers(one: _Inequality, ties: Form, K: float) -> FloatArray:
    """Choose multipliers (2, n) of D_k - s_k^2 = 0 that make the sum of squares of all slopes least."""
    g, slopes = ties.g, K * one.by - one.t_by
    M = np.einsum("kan,kbn->abn", g, g)
    h = -np.einsum("kan,kn->an", g, slopes)
    det = M[0, 0] * M[1, 1] - M[0, 1] ** 2
    regular = det > 1e-10 * M[0, 0] * M[1, 1] + 1e-300
    det = np.where(regular, det, 1.0)
    both = np.stack([(h[0] * M[1, 1] - h[1] * M[0, 1]) / det, (M[0, 0] * h[1] - M[0, 1] * h[0]) / det])
    choices = [np.zeros_like(h), np.where(regular, both, 0.0)]
    for a in range(2):
        alone = np.zeros_like(h)
        alone[a] = h[a] / np.maximum(M[a, a], 1e-300) * (M[a, a] > 1e-300)
        choices.append(alone)
    values = np.stack([_value(one, ties, choice, K) for choice in choices])
    return np.asarray(np.take_along_axis(np.stack(choices), values.argmin(axis=0)[None, None], axis=0)[0])


def _value(one: _Inequality, ties: Form, multipliers: FloatArray, K: float) -> FloatArray:
    """Bound K r_6 - sigma_max from above, rounded up."""
    q = K * one.q - one.t_q + np.einsum("an,pan->pn", multipliers, ties.q)
    terms = np.abs(_slopes(one, ties, multipliers, K)).sum(axis=0) + quadratic_upper(q, len(one.by))
    tied = (multipliers * ties.c).sum(axis=0) + (np.abs(multipliers) * ties.e).sum(axis=0)
    size = K * (np.abs(one.s) + np.abs(one.by).sum(axis=0) + np.abs(one.q).sum(axis=0) + one.above)
    size = size + one.t + np.abs(one.t_by).sum(axis=0) + np.abs(one.t_q).sum(axis=0)
    size = size + (np.abs(multipliers) * ties.size).sum(axis=0)
    return np.asarray(K * (one.s + one.above) - one.t + one.missed + terms + tied + 10.0 * _ROUNDED * size)
