"""Rigorous upper bounds of the condition number kappa = ||H|| ||H^-1|| in the 2-norm, over a whole box.

With Y(t) = Y0 + Y1 t an approximate inverse of H'(t), ||H^-1|| <= ||Y|| / (1 - ||I - Y H'||). The norm of a matrix
linear in t is largest at an end of the interval; that of a matrix of floats is bounded by its singular vectors.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat

from pipeline.arrays import FloatArray
from pipeline.inclusion.closure import Geometry, cross
from pipeline.inclusion.displacement import Displacement
from pipeline.inclusion.following import CARTS, TELESCOPE, Erring
from pipeline.inclusion.krawczyk import Piecewise, linear_inverse, residual_of_inverse
from pipeline.inclusion.matrices import ball_matrix, floats, inner, magnitudes, matrices


@dataclass(frozen=True, eq=False)
class KappaBound:
    """A bound of kappa over a box, infinite if H may be singular, and the sign of det H there (0 if unknown)."""

    kappa: float
    det_sign: int


NO_BOUND = KappaBound(np.inf, 0)


@dataclass(frozen=True, eq=False)
class _Statics:
    """What bounds of kappa need of H' along x(t): Y, and bounds of ||Y||, ||H'|| and ||I - Y H'||."""

    Y: list[arb_mat]
    norm_of_inverse: arb
    norm_of_h: arb
    miss: arb


def kappa_bound(machine: Geometry, series: Piecewise, off: Displacement, errors: Erring | None = None) -> KappaBound:
    """Bound kappa over a box whose joints are `off` those of x(t), or of x(t) + P a for all errors a."""
    if (along := series.derive(_statics, lambda: _statics(series))) is None:
        return NO_BOUND
    by_H, by_YH, over = arb(0), arb(0), series.over
    links = [[entry[0] for entry in vector] for vector in over.vectors], [length[0] for length in over.lengths]
    if errors is not None:
        by_H, by_YH = _change_by_errors(machine, errors, along.Y[0] + along.Y[1] * arb(0, series.half))
        links = errors.hull.vectors, errors.hull.lengths
    change = statics_change(machine, links, off)
    miss = along.miss + along.norm_of_inverse * change + by_YH
    if not miss < 1:
        return NO_BOUND
    det = along.Y[0].det()
    kappa = ((along.norm_of_h + change + by_H) * along.norm_of_inverse / (1 - miss)).abs_upper()
    return KappaBound(above(kappa), int(det > 0) - int(det < 0))


def _statics(series: Piecewise) -> _Statics | None:
    """Bound H' along x(t); None if it is numerically singular."""
    H = matrices(series.at.statics(), series.over.statics(), 3)
    inverse = linear_inverse(H)
    if inverse is None:
        return None
    h, Y = series.half, [ball_matrix(part) for part in inverse]
    H0, H1 = floats(H[0]), floats(H[1])
    rounding = frobenius(magnitudes(H[0] - ball_matrix(H0))) + h * frobenius(magnitudes(H[1] - ball_matrix(H1)))
    norm_of_h = _largest(H0, H1, h) + rounding + h * h * frobenius(magnitudes(H[2]))
    return _Statics(Y, _largest(inverse[0], inverse[1], h), norm_of_h, frobenius(residual_of_inverse(Y, H, h)))


def _change_by_errors(machine: Geometry, erring: Erring, Y: arb_mat) -> tuple[arb, arb]:
    """Bound how much H' and Y H' change by all errors of the actuators, in the 2-norm.

    With D_k enclosing the derivative of H' by the error of actuator k, along x = x(t) + P a and q = q(t) + a, the
    change is sum a_k D_k for some matrices in the enclosures: a convex function of a but for their radii, so that its
    largest norm is that of a corner.
    """
    errors = erring.following.errors
    changes = statics_derivatives(machine, erring)
    by_H = [change * error for change, error in zip(changes, errors, strict=True) if error > 0]
    return largest_corner(by_H), largest_corner([Y * change for change in by_H])


def statics_derivatives(machine: Geometry, erring: Erring) -> list[arb_mat]:
    """Enclose the derivatives of H' by the error of each actuator over a box: five 6 x 6 matrices.

    v_l changes by dv = P_xyz + T P_angles - d for the link's own cart, T the axes crossed with the arm, m_l by
    (T P_angles) x v + A' x dv, and row l of H' is [v ; m / L] / len.
    """
    hull, table = erring.hull, erring.following.over.table()
    shift, turn = arb_mat(table[:3]), arb_mat(table[3:])
    rows: list[list[list[arb]]] = []
    for link, (arm, vector, length) in enumerate(zip(hull.arms, hull.vectors, hull.lengths, strict=True)):
        turned = arb_mat([cross(axis, arm) for axis in hull.axes]).transpose() * turn
        moved = shift + turned
        for k, along in enumerate(hull.rails[link]):
            moved[k, CARTS[link]] -= along
        moment = skew(arm) * moved - skew(vector) * turned
        parts = [*moved.table(), *(moment / machine.characteristic_length).table()]
        columns = [[entry / length for entry in column] for column in zip(*parts, strict=True)]
        if link in TELESCOPE:
            k = TELESCOPE[link]
            row = [*vector, *(m / machine.characteristic_length for m in hull.moments[link])]
            columns[k] = [entry - part / length**2 for entry, part in zip(columns[k], row, strict=True)]
        rows.append(columns)
    return [arb_mat([columns[k] for columns in rows]) for k in range(len(rows[0]))]


def largest_corner(changes: list[arb_mat]) -> arb:
    """Bound the largest ||sum e_k M_k||_2 over |e_k| <= 1, for n matrices 6 x 6 of balls.

    Middles in floats: with V nearly orthogonal, ||M||^2 <= ||(M V)' (M V)||_inf / (1 - ||I - V' V||_inf), where all
    roundings together are below 1e-12 of the Frobenius norms.
    """
    middles = np.stack([floats(change) for change in changes])
    spread = sum(
        (frobenius(magnitudes(change - ball_matrix(m))) for change, m in zip(changes, middles, strict=True)), arb(0)
    )
    if not np.isfinite(middles).all():
        return arb("inf")
    n = len(middles)
    signs = 1.0 - 2.0 * ((np.arange(2 ** (n - 1))[:, None] >> np.arange(n)) & 1)
    sums = np.einsum("ck,kij->cij", signs, middles)
    V = np.linalg.svd(sums)[2].swapaxes(1, 2)
    turned = sums @ V
    total = float(np.square(middles).sum() * n)
    loss = np.abs(V.swapaxes(1, 2) @ V - np.eye(6)).sum(axis=2).max(axis=1) + 1e-12
    square = np.abs(turned.swapaxes(1, 2) @ turned).sum(axis=2).max(axis=1) + 1e-12 * total
    return arb(float(np.sqrt((square / (1.0 - loss)).max() * (1.0 + 1e-12)) * (1.0 + 1e-12))) + spread


def skew(v: list[arb]) -> arb_mat:
    """Return the matrix of v x (.)."""
    return arb_mat([[arb(0), -v[2], v[1]], [v[2], arb(0), -v[0]], [-v[1], v[0], arb(0)]])


def above(value: arb) -> float:
    """Return a float that is certainly not below a ball."""
    return float(np.nextafter(float(value.upper()), np.inf))


def below(value: arb) -> float:
    """Return a float that is certainly not above a ball."""
    return float(np.nextafter(float(value.lower()), -np.inf))


def spectral_norm(M: FloatArray) -> arb:
    """Bound ||M||_2 of a matrix of floats (6, 6).

    With V nearly orthogonal, ||M||^2 <= ||(M V)' (M V)||_inf / (1 - ||I - V' V||_inf).
    """
    if not np.isfinite(M).all():
        return arb("inf")
    V = ball_matrix(np.linalg.svd(M)[2].T)
    MV = ball_matrix(M) * V
    loss = _row_sum(V.transpose() * V - ball_matrix(np.eye(len(M))))
    if not loss < 1:
        return arb("inf")
    return (_row_sum(MV.transpose() * MV) / (1 - loss)).sqrt().abs_upper()


def statics_change(machine: Geometry, links: tuple[list[list[arb]], list[arb]], off: Displacement) -> arb:
    """Bound the change of H in the Frobenius norm with joints and lengths.

    `links` are the vectors (6 x 3) and lengths (6,) of the links before. Row l is [v ; m / L] / len, with |m| at most
    the distance of the joint from the TCP times |v|.
    """
    total, L = arb(0), machine.characteristic_length
    changes = zip(off.vectors, off.arms, off.lengths, strict=True)
    for point, vector, length, (by_vector, by_arm, longer) in zip(machine.points, *links, changes, strict=True):
        arm, size = norm(point), norm(vector)
        by_moment = (arm * by_vector + by_arm * (size + by_vector)) / L
        change = (by_vector**2 + by_moment**2).sqrt()
        if longer > 0:
            change += size * (1 + (arm / L) ** 2).sqrt() * longer / length.abs_lower()
        left = length.abs_lower() - longer
        total += (change / left) ** 2 if left > 0 else arb("inf")
    return total.sqrt().abs_upper()


def norm(vector: list[arb]) -> arb:
    """Bound the Euclidean norm of a vector."""
    squares = [entry.abs_upper() ** 2 for entry in vector]
    return sum(squares, arb(0)).sqrt().abs_upper()


def frobenius(bounds: list[list[arb]]) -> arb:
    """Bound the Frobenius norm of a matrix by bounds of its entries."""
    total = arb(0)
    for row in bounds:
        total += inner(row, row)
    return total.sqrt().abs_upper()


def _largest(M0: FloatArray, M1: FloatArray, h: arb) -> arb:
    """Bound ||M0 + M1 t|| for |t| <= h: a convex function of t, largest at an end."""
    half = float(h.mid())
    bounds = []
    for sign in (-half, half):
        end = M0 + sign * M1
        exact = ball_matrix(M0) + ball_matrix(M1) * arb(sign)
        bounds.append(spectral_norm(end) + frobenius(magnitudes(exact - ball_matrix(end))))
    return bounds[0].max(bounds[1])


def _row_sum(matrix: arb_mat) -> arb:
    """Bound the largest row sum of absolute values."""
    largest = arb(0)
    for row in magnitudes(matrix):
        largest = largest.max(sum(row, arb(0)))
    return largest
