"""Rigorous upper bounds of the condition number kappa = ||H|| ||H^-1|| in the 2-norm, over a whole box.

With Y(t) = Y0 + Y1 t an approximate inverse of H'(t), ||H^-1|| <= ||Y|| / (1 - ||I - Y H'||). The norm of a matrix
linear in t is largest at an end of the interval; that of a matrix of floats is bounded by its singular vectors.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat, arb_series

from pipeline.arrays import FloatArray
from pipeline.inclusion.closure import Closure, Geometry
from pipeline.inclusion.krawczyk import Piecewise, linear_inverse, residual_of_inverse
from pipeline.inclusion.matrices import ball_matrix, floats, inner, magnitudes, matrices


@dataclass(frozen=True, eq=False)
class KappaBound:
    """A bound of kappa over a box, infinite if H may be singular, and the sign of det H there (0 if unknown)."""

    kappa: float
    det_sign: int


NO_BOUND = KappaBound(np.inf, 0)


def kappa_bound(machine: Geometry, series: Piecewise, deviation: list[arb]) -> KappaBound:
    """Bound kappa over a box whose pose is within `deviation` (6,) of x(t)."""
    H = matrices(series.at.statics(), series.over.statics(), 3)
    Y = linear_inverse(H)
    if Y is None:
        return NO_BOUND
    h = series.half
    off = statics_change(machine, series.over, deviation)
    bound_Y = _largest(Y[0], Y[1], h)
    H0, H1 = floats(H[0]), floats(H[1])
    rounding = frobenius(magnitudes(H[0] - ball_matrix(H0))) + h * frobenius(magnitudes(H[1] - ball_matrix(H1)))
    bound_H = _largest(H0, H1, h) + rounding + h * h * frobenius(magnitudes(H[2])) + off
    miss = frobenius(residual_of_inverse([ball_matrix(part) for part in Y], H, h)) + bound_Y * off
    if not miss < 1:
        return NO_BOUND
    det = ball_matrix(Y[0]).det()
    kappa = (bound_H * bound_Y / (1 - miss)).abs_upper()
    return KappaBound(above(kappa), int(det > 0) - int(det < 0))


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


def statics_change(machine: Geometry, over: Closure[arb_series], deviation: list[arb]) -> arb:
    """Bound the change of H in the Frobenius norm as the pose deviates by up to `deviation` (6,), metres and radians.

    No Euler angle moves a joint farther than its distance from the TCP times the angle.
    """
    shift, turn = norm(deviation[:3]), sum((d.abs_upper() for d in deviation[3:]), arb(0))
    total = arb(0)
    for point, vector, length in zip(machine.points, over.vectors, over.lengths, strict=True):
        arm = norm(point)
        by_vector = shift + arm * turn
        size = norm([entry[0] for entry in vector])
        by_moment = (arm * by_vector + arm * turn * (size + by_vector)) / machine.characteristic_length
        total += (by_vector**2 + by_moment**2) / length[0].abs_lower() ** 2
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
