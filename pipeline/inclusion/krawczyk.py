"""One box: a Krawczyk inclusion over a whole interval of s, with uncertain parameters kept as symbols.

For s = c + t, |t| <= h, and every value of the uncertain parameters, the pose is sought in

    X(t, e) = x(t) + C(t) e + [-r, r],

where x(t) is a cubic, C(t) = C0 + C1 t an approximate inverse of the Jacobian J(t) = f'(x(t), t), and e, at most E, the
change of the six closures at x(t) by the uncertain parameters: to first order it moves the pose by C e.
With G_i = sum_l C_il f_l'' over all of X, and D a bound on the change of J by the parameters,

    k = |C f(x)| + |I - C J| |C| E + 1/2 |C' G C| (E, E) + |C| D |C| E + Q r,
    Q = |I - C J| + |G C| E + |G| r + |C| D

bounds how far the Krawczyk image of X reaches from x + C e. If k < r in all six coordinates, X holds exactly one
solution for each t and each value of the parameters, and the closure Jacobian is regular on all of X.
With actuators that are off by a, |a_k| <= A_k, there is one more symbol, and one more part of k and Q
(`pipeline.inclusion.following`):

    X(t, e, a) = x(t) + C(t) e + P(t) a + [-r, r].

Everything that depends on t is a power series whose last term holds for the whole interval.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat, arb_series

from pipeline.arrays import FloatArray
from pipeline.inclusion.closure import (
    TERMS,
    Closure,
    Geometry,
    closure,
    pose_series,
    second_derivatives,
    shifted,
)
from pipeline.inclusion.following import NO_FOLLOWING, Following, follow_actuators
from pipeline.inclusion.matrices import added, ball_matrix, floats, inner, magnitudes, matrices, times
from pipeline.inclusion.pieces import Piece, middle
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty, jacobian_change, residual_change

_SIZE = 6
_ATTEMPTS = 3
_INFLATION = 1.5
SLACK = arb(0.95)
"""Share of a radius that has to suffice, so that other arithmetic with wider enclosures can verify the same boxes."""
LEAST_RADIUS = 1e-6
"""Least radius of a box in metres and radians, so that neighbours overlap despite rounding."""


@dataclass(frozen=True, eq=False)
class Box:
    """The poses among which the solution is sought over an interval of s; stored in certificates.

    Attributes
    ----------
    first, last : float
        The interval of s.
    pose : (4, 6)
        Taylor coefficients of x about the middle of the interval.
    radius : (6,)
        r, in metres and radians.
    """

    first: float
    last: float
    pose: FloatArray
    radius: FloatArray


@dataclass(frozen=True, eq=False)
class Inclusion:
    """A proven box.

    Attributes
    ----------
    box : Box
        The box.
    inverse : (2, 6, 6)
        C0 and C1.
    image : (6,) balls
        k: a bound of how far the solution is from x + C e + P a.
    residual_change : (6,) balls
        E.
    jacobian_change : 6 x 6 balls
        D, over all of the box.
    following : Following
        P and A.
    """

    box: Box
    inverse: FloatArray
    image: list[arb]
    residual_change: list[arb]
    jacobian_change: list[list[arb]]
    following: Following = NO_FOLLOWING


@dataclass(frozen=True, eq=False)
class Piecewise:
    """The closures along x(t): series about the middle of the interval, and series about every t in it."""

    half: arb
    at: Closure[arb_series]
    over: Closure[arb_series]


def along(machine: Geometry, piece: Piece, box: Box) -> Piecewise:
    """Evaluate the closures along the cubic of a box."""
    centre, half = middle(box.first, box.last)
    q = [[arb(value) for value in coefficients] for coefficients in piece.taylor(centre)]
    at, over = (
        closure(machine, pose_series(box.pose, tau), [shifted(coefficients, tau) for coefficients in q])
        for tau in (arb(0), arb(0, half))
    )
    return Piecewise(arb(half), at, over)


def include(
    machine: Geometry, series: Piecewise, box: Box, uncertainty: Uncertainty = CERTAIN, attempts: int = _ATTEMPTS
) -> Inclusion | None:
    """Prove a box, with larger radii if its own are too small; None if that fails."""
    J = matrices(series.at.jacobian(), series.over.jacobian(), 3)
    inverse = linear_inverse(J)
    if inverse is None:
        return None
    C = [ball_matrix(part) for part in inverse]
    h = series.half
    C_over = C[0] + C[1] * arb(0, h)
    C_abs = magnitudes(C_over)
    miss = residual_of_inverse(C, J, h)
    E = residual_change(machine, series.over, uncertainty)
    following = follow_actuators((series.at, series.over), inverse, J, h, uncertainty.actuator_m)
    moved = added(times(C_abs, E), following.moved)
    rest = added(_residual(C, series, h), following.miss)
    if uncertainty.calibration:
        rest = added(rest, times(miss, times(C_abs, E)))
    for _ in range(attempts):
        radius = [arb(value) for value in box.radius]
        reach = added(moved, radius)
        hull = _hull(machine, series, reach)
        D = jacobian_change(machine, hull, uncertainty)
        image = _image(C_over, hull, (miss, rest, E, moved, D), following, radius)
        if all(k < r * SLACK for k, r in zip(image, radius, strict=True)):
            return Inclusion(box, inverse, image, E, D, following)
        if not all(k.is_finite() and k < 1 for k in image):
            return None
        wider = np.maximum(LEAST_RADIUS, [_INFLATION * float(k.upper()) for k in image])
        box = Box(box.first, box.last, box.pose, np.maximum(wider, box.radius))
    return None


def _residual(C: list[arb_mat], series: Piecewise, h: arb) -> list[arb]:
    """Bound |C(t) f(x(t), t)|."""
    at, over = series.at.residuals(), series.over.residuals()
    table = [[at[link][n] if n + 1 < TERMS else over[link][n] for n in range(TERMS)] for link in range(_SIZE)]
    f = arb_mat(table)
    bound = [arb(0)] * _SIZE
    for power, product in enumerate((C[0] * f, C[1] * f)):
        for i in range(_SIZE):
            for n in range(TERMS):
                bound[i] += product[i, n].abs_upper() * h ** (n + power)
    return bound


def _hull(machine: Geometry, series: Piecewise, reach: list[arb]) -> Closure[arb]:
    """Evaluate the closures over all poses of a box, in plain balls."""
    pose = [coordinate[0] + arb(0, r.upper()) for coordinate, r in zip(series.over.pose, reach, strict=True)]
    return closure(machine, pose, [q[0] for q in series.over.q])


def _image(
    C: arb_mat,
    hull: Closure[arb],
    known: tuple[list[list[arb]], list[arb], list[arb], list[arb], list[list[arb]]],
    following: Following,
    radius: list[arb],
) -> list[arb]:
    """Bound k of a box (see the module)."""
    miss, rest, E, moved, D = known
    G = (C * arb_mat(second_derivatives(hull))).entries()
    image, C_abs = [], magnitudes(C)
    uncertain = not all(e.is_zero() for e in E)
    change = added(times(D, moved), times(D, radius))
    slopes = following.slopes(C, hull)
    for i in range(_SIZE):
        Gi = arb_mat(_SIZE, _SIZE, G[36 * i : 36 * (i + 1)])
        spread = times(magnitudes(Gi), radius)
        k = rest[i] + inner(miss[i], radius)
        if uncertain:
            GC = Gi * C
            spread = added(spread, times(magnitudes(GC), E))
            k += inner(E, times(magnitudes(C.transpose() * GC), E)) / 2
            k += inner(C_abs[i], change)
        if following.any:
            bent = Gi * following.over + slopes[i]
            spread = added(spread, times(magnitudes(bent), following.errors))
            k += following.second_order(i, C, Gi, slopes[i])
            if uncertain:
                k += inner(E, times(magnitudes(C.transpose() * bent), following.errors))
        image.append(k + inner(spread, radius))
    return image


def linear_inverse(J: list[arb_mat]) -> FloatArray | None:
    """Compute C0 = J0^-1 and C1 = -C0 J1 C0 in floats, shape (2, 6, 6); None if J0 is numerically singular."""
    J0, J1 = (floats(part) for part in J[:2])
    if not (np.isfinite(J0).all() and np.isfinite(J1).all()):
        return None
    try:
        C0 = np.linalg.inv(J0)
    except np.linalg.LinAlgError:
        return None
    return np.stack([C0, -C0 @ J1 @ C0])


def residual_of_inverse(C: list[arb_mat], J: list[arb_mat], h: arb) -> list[list[arb]]:
    """Bound |I - C(t) J(t)| for J = J0 + J1 t + J2 t^2, where J2 holds for the whole interval. 6 x 6 bounds."""
    identity = arb_mat(_SIZE, _SIZE, [arb(int(i == j)) for i in range(_SIZE) for j in range(_SIZE)])
    terms = (identity - C[0] * J[0], C[0] * J[1] + C[1] * J[0], C[0] * J[2] + C[1] * J[1], C[1] * J[2])
    total = [arb(0)] * (_SIZE * _SIZE)
    for power, term in enumerate(terms):
        scale = h**power
        total = [bound + entry.abs_upper() * scale for bound, entry in zip(total, term.entries(), strict=True)]
    return [total[_SIZE * i : _SIZE * (i + 1)] for i in range(_SIZE)]
