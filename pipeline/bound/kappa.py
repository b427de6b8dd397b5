"""Lower bounds of kappa over boxes: no pose of a box has both kappa <= K and the start's sign of det H.

At the centre H = U diag(sigma) V'. With matrices U, V of floats, nearly orthogonal, U' H V has the blocks A (5 x 5), b,
c', d. Where A is regular all over a box, det H has the sign of det U det V S, S = d - c' A^-1 b; and with
w = V (-A^-1 b, 1), H w = U^-T (0, S), so that sigma_min <= |S|, up to what U and V miss. Hence kappa > K, or det H is
zero or of the other sign, wherever

    K S < sigma_max,    S taken with the sign that belongs to the start's det H.

For any z linear in the box's coordinates, r = U' H V (z, 1) gives S = r_6 - c' A^-1 r_(1..5) exactly. With z that of
first order, r_(1..5) is of second and c of first order: the last term is of third order, and r_6 a quadratic form that
is summed as a number. Both sides become one linear form, to which multiples of D_k - s_k^2 = 0 are added.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.bound.forms import Form

_UP = 1.0 + 1e-11
"""More than all roundings of sums of at most 10,000 products of one sign, relative to them."""
_ROUNDED = 1e-12
"""More than the roundings of any sum here, relative to the sum of its terms' magnitudes: none has over 1,000 terms."""
_ORTHOGONAL = 1e-12
_LEAST_SIGMA = 1e-6
"""Boxes whose H has a smaller second least singular value at the centre are left undecided."""
LARGEST = 1e7
"""Largest kappa that is told from infinity."""


@dataclass(frozen=True, eq=False)
class KappaBounds:
    """Bounds for n boxes.

    Attributes
    ----------
    least : (n,)
        kappa is larger all over the box, or det H is zero or of the other sign; at most `LARGEST`. Zero where nothing
        is proven.
    middle : (n,)
        kappa at the centre in floats, infinite with the other sign.
    spread : (N, n)
        How much each coordinate contributes to what is not certain.
    """

    least: FloatArray
    middle: FloatArray
    spread: FloatArray


def statics(v: Form, joints_m: FloatArray, inverse_lengths: Form, unit_m: float) -> tuple[Form, Form]:
    """Compute u_l (6, 3, n) and H as columns, (6 links, 6 rows, n), moments divided by `unit_m`."""
    u = v * Form(
        inverse_lengths.c[:, None],
        inverse_lengths.g[:, :, None],
        inverse_lengths.e[:, None],
        inverse_lengths.size[:, None],
    )
    a = joints_m[:, :, None] / unit_m
    moments = []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        moments.append(u[:, k].times(a[:, j]) - u[:, j].times(a[:, k]))
    H = Form(
        *(
            np.concatenate([getattr(u, part), np.stack([getattr(m, part) for m in moments], axis)], axis=axis)
            for part, axis in (("c", 1), ("g", 2), ("e", 1), ("size", 1))
        )
    )
    return u, H


def kappa_bounds(u: Form, H: Form, joints_m: FloatArray, mismatch: Form, sign: float, target: float) -> KappaBounds:
    """Bound kappa over boxes; multipliers and the spread are for kappa near `target`."""
    centre = np.ascontiguousarray(H.c.transpose(2, 1, 0))
    U, sigma, Vt = np.linalg.svd(centre)
    V = Vt.transpose(0, 2, 1)
    orientation = np.linalg.det(U @ Vt) * sign
    skew = [np.abs(M.transpose(0, 2, 1) @ M - np.eye(6)).sum(axis=(1, 2)) for M in (U, V)]
    usable = (np.maximum(*skew) < _ORTHOGONAL) & (np.abs(np.abs(orientation) - 1.0) < 1e-6)
    signed = np.where(orientation > 0.0, 1.0, -1.0)
    U, V, sigma = U.transpose(1, 2, 0), V.transpose(1, 2, 0), sigma.T
    left, right = U[:, 5], V[:, 5]
    # Of H_k: rows u_6' H_k V, columns U' H_k v_6, norms.
    rows = np.einsum("in,klin->kln", left, H.g)
    c = np.einsum("kln,ljn->kjn", rows, V)
    b = np.einsum("ijn,kin->kjn", U, np.einsum("klin,ln->kin", H.g, right))
    sizes = np.sqrt(np.einsum("klin,klin->kn", H.g, H.g)).sum(axis=0)
    errors = np.sqrt(np.einsum("lin,lin->n", H.e, H.e)) * _UP
    rounding = _ROUNDED * (np.sqrt(np.einsum("lin,lin->n", H.c, H.c)) + sizes + errors)
    scale = 1.0 / np.sqrt(np.maximum(sigma[:5], _LEAST_SIGMA))
    z = -b[:, :5] / np.maximum(sigma[:5], _LEAST_SIGMA)
    long = 1.0 + np.sqrt(np.einsum("kjn,kjn->kn", z, z)).sum(axis=0) * _UP
    beyond = _third_order(
        U, V, H.g, (b + sigma * np.concatenate([z, np.zeros_like(z[:, :1])], axis=1))[:, :5], z, scale
    )
    # r_6 = sigma_6 + sum c_k6 x_k + sum (c_k . z_m) x_k x_m: squares count only where they add.
    linear = c[:, 5] * signed
    quadratic = np.einsum("kjn,mjn->kmn", c[:, :5], z) * signed
    N = len(quadratic)
    diagonal = quadratic[range(N), range(N)]
    mixed = np.abs(quadratic + quadratic.transpose(1, 0, 2))
    mixed[range(N), range(N)] = 0.0
    curved = np.maximum(diagonal, 0.0).sum(axis=0) + 0.5 * mixed.sum(axis=(0, 1))
    # The errors of u_l: y' dH z = sum z_l (y_f + y_m x a_l) . du_l.
    of_errors = _per_link(left, joints_m, u.e)
    vector = np.abs(right) + np.abs(np.einsum("ljn,kjn->kln", V[:, :5], z)).sum(axis=0)
    first = (of_errors * vector).sum(axis=0)
    # |c' A^-1 r| with rows and columns of A scaled by 1 / sqrt(sigma), so that its centre is the identity.
    loose = (errors + rounding) * scale[4]
    beta = beyond.change + loose * scale[4]
    third = (
        (
            np.sqrt(np.einsum("kjn,kjn->kn", c[:, :5] * scale, c[:, :5] * scale)).sum(axis=0)
            + (np.sqrt((of_errors**2).sum(axis=0)) + rounding) * scale[4]
        )
        * (beyond.residual + loose * long)
        / np.where(beta < 1.0, 1.0 - beta, 1.0)
    )
    above = (curved + first + third) * _UP + 4.0 * rounding * long
    # sigma_max >= u_1' H v_1.
    largest = np.einsum("in,kin->kn", U[:, 0], np.einsum("klin,ln->kin", H.g, V[:, 0]))
    missed = (_per_link(U[:, 0], joints_m, u.e) * np.abs(V[:, 0])).sum(axis=0) * _UP + 4.0 * rounding
    parts = _Parts(signed * sigma[5], linear, above, sigma[0], largest, missed)
    multipliers = _multipliers(parts, mismatch, target)
    least = _largest_excluded(parts, mismatch, multipliers, target)
    least = np.where(usable & (sigma[4] > _LEAST_SIGMA) & (beta * _UP < 1.0) & np.isfinite(above), least, 0.0)
    with np.errstate(divide="ignore"):
        middle = np.where(signed > 0.0, sigma[0] / np.maximum(sigma[5], 1e-300), np.inf)
    spread = np.abs(_slopes(parts, mismatch, multipliers, target)) + target * (mixed.sum(axis=1) + np.abs(diagonal))
    return KappaBounds(least, middle, spread)


@dataclass(frozen=True, eq=False)
class _Beyond:
    """Bounds (n,): how far the scaled A is from the identity, and the scaled r_1 ... r_5."""

    change: FloatArray
    residual: FloatArray


def _third_order(
    U: FloatArray, V: FloatArray, slopes: FloatArray, left_over: FloatArray, z: FloatArray, scale: FloatArray
) -> _Beyond:
    """Bound the changes of A and the rest r of second order, entry by entry, both scaled; errors of H not included."""
    by_rows = np.einsum("ijn,klin->kjln", U[:, :5], slopes)
    changes = np.abs(np.einsum("kjln,lmn->kjmn", by_rows, V[:, :5])).sum(axis=0) * scale[:, None] * scale
    rest = (np.abs(left_over) * scale).sum(axis=0) + np.einsum("jmn,mn->jn", changes, (np.abs(z) / scale).sum(axis=0))
    return _Beyond(
        np.sqrt((changes**2).sum(axis=(0, 1))) * _UP,
        np.sqrt((rest**2).sum(axis=0)) * _UP,
    )


@dataclass(frozen=True, eq=False)
class _Parts:
    """S <= s + by . x + above and sigma_max >= t + t_by . x - missed."""

    s: FloatArray
    by: FloatArray
    above: FloatArray
    t: FloatArray
    t_by: FloatArray
    missed: FloatArray


def _per_link(y: FloatArray, joints_m: FloatArray, error: FloatArray) -> FloatArray:
    """Bound |(y_f + y_m x a_l) . du_l| for |du_l| <= error (6, 3, n). Shape (6, n)."""
    total = np.zeros_like(error[:, 0])
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        turned = y[3 + j] * joints_m[:, k, None] - y[3 + k] * joints_m[:, j, None]
        total += (np.abs(y[i] + turned) + 1e-14) * error[:, i]
    return total * _UP


def _slopes(parts: _Parts, mismatch: Form, multipliers: FloatArray, K: float | FloatArray) -> FloatArray:
    return np.asarray(K * parts.by - parts.t_by + np.einsum("an,kan->kn", multipliers, mismatch.g))


def _multipliers(parts: _Parts, mismatch: Form, K: float) -> FloatArray:
    """Choose multipliers (2, n) of D_k - s_k^2 = 0 that make the sum of squares of all slopes least."""
    g, slopes = mismatch.g, K * parts.by - parts.t_by
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
    values = np.stack([_value(parts, mismatch, choice, K) for choice in choices])
    return np.asarray(np.take_along_axis(np.stack(choices), values.argmin(axis=0)[None, None], axis=0)[0])


def _value(parts: _Parts, mismatch: Form, multipliers: FloatArray, K: float | FloatArray) -> FloatArray:
    """Bound K S - sigma_max from above, rounded up."""
    terms = np.abs(_slopes(parts, mismatch, multipliers, K)).sum(axis=0)
    ties = (multipliers * mismatch.c).sum(axis=0)
    loose = (np.abs(multipliers) * mismatch.e).sum(axis=0)
    size = K * (np.abs(parts.s) + np.abs(parts.by).sum(axis=0) + parts.above) + parts.t + np.abs(parts.t_by).sum(axis=0)
    size = size + (np.abs(multipliers) * mismatch.size).sum(axis=0)
    value = K * (parts.s + parts.above) - parts.t + parts.missed + terms + ties + loose
    return np.asarray(value + 10.0 * _ROUNDED * size, dtype=float)


def _largest_excluded(parts: _Parts, mismatch: Form, multipliers: FloatArray, target: float) -> FloatArray:
    """Find the largest K for which the test holds: infinite if for all, zero if not even for a small one.

    The value is convex in K, and negative for K = 0 or never: bisection in log K.
    """
    n = len(parts.s)
    endless = _value(parts, mismatch, multipliers, LARGEST) < 0.0
    low, high = np.zeros(n), np.full(n, np.log(LARGEST))
    passes = _value(parts, mismatch, multipliers, target) < 0.0
    least = np.where(passes, target, 0.0)
    low = np.where(passes, np.log(target), 0.0)
    high = np.where(passes, high, np.log(target))
    for _ in range(10):
        middle = 0.5 * (low + high)
        K = np.exp(middle)
        good = _value(parts, mismatch, multipliers, K) < 0.0
        least = np.where(good, np.maximum(least, K), least)
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    return np.where(endless, LARGEST, least)
