"""A rigorous lower bound of the stiffness that gravity gives the drives, over a whole box.

The least eigenvalue of K (`machine.actuator_space.gravity_stiffness`) is bounded through an enclosure of K itself,

    K in K0 + K1 t + K2 t^2,   |t| <= h,

with K0 and K1 about the middle of the box and K2 about every t in it, all for every pose within the box's deviation
from its cubic. The least eigenvalue of a matrix linear in t is concave, hence least at an end; what K differs by from
it counts in the Frobenius norm (Weyl). That of a matrix of floats is bounded by Gershgorin's circles after a congruence
with its approximate eigenvectors.
"""

import numpy as np
from flint import arb, arb_mat, arb_series

from pipeline.arrays import FloatArray
from pipeline.inclusion.closure import TERMS, Closure, Vector, closure, component, cross, dot, pose_series, shifted
from pipeline.inclusion.condition import above, below, frobenius
from pipeline.inclusion.matrices import ball_matrix, floats, inner, magnitudes
from pipeline.inclusion.pieces import middle
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.machine.actuator_space.rates import EXTENSIONS
from pipeline.machine.geometry import ARM_OF_LINK
from pipeline.machine.masses import Masses, RigidBody, lumped_platform

_LINKS, _ACTUATORS = EXTENSIONS.shape
_ORDERS = 3

MatrixSeries = list[arb_mat]
"""The coefficients of a matrix of series, orders 0 to 2."""


def least_stiffness_bound(box: ProvenBox, masses: Masses) -> tuple[float, float]:
    """Bound the least eigenvalue of K over a box from below, and say how much of that is K's deviation from a line.

    Both in N/m; -inf and inf if H may be singular.
    """
    unknown = -np.inf, np.inf
    body, h = lumped_platform(masses, box.machine.platform_points_m), box.series.half
    try:
        about, everywhere = (_stiffness(_off_the_cubic(box, tau), masses, body) for tau in (arb(0), arb(0, h.upper())))
    except ZeroDivisionError:
        return unknown
    K0, K1, K2 = about[0], about[1], everywhere[2]
    M0, M1 = ((floats(K) + floats(K).T) / 2.0 for K in (K0, K1))
    rest = frobenius(magnitudes(K0 - ball_matrix(M0))) + h * frobenius(magnitudes(K1 - ball_matrix(M1)))
    rest += h * h * frobenius(magnitudes(K2))
    if not rest.is_finite():
        return unknown
    half, ends = float(h.mid()), []
    for t in (-half, half):
        end = M0 + t * M1
        rounding = frobenius(magnitudes(ball_matrix(M0) + ball_matrix(M1) * arb(t) - ball_matrix(end)))
        ends.append(_least_eigenvalue(end) - rounding)
    return below(ends[0].min(ends[1]) - rest), above(rest)


def _off_the_cubic(box: ProvenBox, tau: arb) -> Closure[arb_series]:
    """Evaluate the closures about t = tau for every pose that is off the cubic by a constant within the deviation.

    At the pose of t that constant is its own deviation, so that what holds for all of them holds there.
    """
    interval = box.inclusion.box
    centre, _ = middle(interval.first, interval.last)
    pose = [
        coordinate + arb_series([arb(0, deviation.abs_upper())], prec=TERMS)
        for coordinate, deviation in zip(pose_series(interval.pose, tau), box.inclusion.image, strict=True)
    ]
    q = [shifted([arb(value) for value in coefficients], tau) for coefficients in box.piece.taylor(centre)]
    return closure(box.balls, pose, q)


def _stiffness(motion: Closure[arb_series], masses: Masses, body: RigidBody) -> MatrixSeries:
    """Compute K as a series.

    Raises
    ------
    ZeroDivisionError
        If H may be singular.
    """
    rows, per_length = motion.statics(), 1 / motion.characteristic_length
    by_actuator = [[_constant(entry) for entry in row] for row in EXTENSIONS.tolist()]
    for link, arm in enumerate(ARM_OF_LINK.tolist()):
        by_actuator[link][arm] = component(rows[link][:3], motion.rails[link])
    H, scale = _coefficients(rows), arb_mat(np.diag([1.0] * 6).tolist())
    for k in range(3, 6):
        scale[k, k] = per_length
    twist = [scale * part for part in _solved(H, _coefficients(by_actuator))]
    weight = [_constant(value) for value in (-body.mass_kg * masses.gravity_mps2).tolist()]
    centre = [dot(row, [_constant(value) for value in body.centre_m.tolist()]) for row in motion.rotation]
    wrench = [[part] for part in weight] + [[part * per_length] for part in cross(centre, weight)]
    link_n = _entries(_solved([part.transpose() for part in H], _coefficients(wrench)))
    turning, K = _turning(weight, centre), [arb_mat(_ACTUATORS, _ACTUATORS)] * _ORDERS
    for link, force in enumerate(link_n):
        pushed = _turning([force * part for part in rows[link][:3]], motion.arms[link])
        turning = [
            [one - other for one, other in zip(*pair, strict=True)] for pair in zip(turning, pushed, strict=True)
        ]
        tip = _times(_coefficients(_tip(motion.arms[link])), twist)
        for k, along in enumerate(motion.rails[link]):
            tip[0][k, ARM_OF_LINK[link]] -= along
        extension = ball_matrix(EXTENSIONS[[link]])
        bent = _times([part.transpose() for part in tip], tip)
        bent[0] = bent[0] - extension.transpose() * extension
        K = _minus(K, _scaled(force / motion.lengths[link], bent))
    spin = [arb_mat(part.table()[3:]) for part in twist]
    return _plus(K, _times([part.transpose() for part in spin], _times(_coefficients(turning), spin)))


def _tip(arm: Vector) -> list[Vector]:
    """Write v + omega x A' as a matrix (3, 6) of the twist (v, omega)."""
    x, y, z = arm
    one, none = _constant(1.0), _constant(0.0)
    return [[one, none, none, none, z, -y], [none, one, none, -z, none, x], [none, none, one, y, -x, none]]


def _turning(a: Vector, b: Vector) -> list[Vector]:
    """Compute S(a, b) = (a b' + b a') / 2 - (a . b) 1."""
    half, along = arb(0.5), dot(a, b)
    return [[(a[i] * b[j] + b[i] * a[j]) * half - (along if i == j else 0) for j in range(3)] for i in range(3)]


def _constant(value: float) -> arb_series:
    return arb_series([arb(value)], prec=TERMS)


def _coefficients(matrix: list[Vector]) -> MatrixSeries:
    return [arb_mat([[entry[n] for entry in row] for row in matrix]) for n in range(_ORDERS)]


def _entries(column: MatrixSeries) -> Vector:
    return [arb_series([part[k, 0] for part in column], prec=_ORDERS) for k in range(column[0].nrows())]


def _solved(A: MatrixSeries, B: MatrixSeries) -> MatrixSeries:
    """Solve A X = B order by order: A0 Xn = Bn - A1 X(n-1) - ... - An X0.

    With Y an approximate inverse of A0, X = Y B + (1 - Y A0) X, and ||X|| <= ||Y B|| / (1 - ||1 - Y A0||) in the
    largest row sum.

    Raises
    ------
    ZeroDivisionError
        If A0 may be singular.
    """
    inverse = _approximate_inverse(A[0])
    miss = magnitudes(ball_matrix(np.eye(_LINKS)) - inverse * A[0])
    found: MatrixSeries = []
    for n in range(_ORDERS):
        right = B[n]
        for k in range(1, n + 1):
            right = right - A[k] * found[n - k]
        found.append(_refined(inverse * right, miss))
    return found


def _approximate_inverse(matrix: arb_mat) -> arb_mat:
    try:
        return ball_matrix(np.linalg.inv(floats(matrix)).astype(float))
    except np.linalg.LinAlgError:
        raise ZeroDivisionError from None


def _refined(near: arb_mat, miss: list[list[arb]]) -> arb_mat:
    """Enclose X = near + E X for |E| <= miss (6, 6)."""
    loss = _largest([sum(row, arb(0)) for row in miss])
    if not loss < 1:
        raise ZeroDivisionError
    found = []
    for column in near.transpose().table():
        size = _largest(column) / (1 - loss)
        each = [entry.abs_upper() + sum(row, arb(0)) * size for entry, row in zip(column, miss, strict=True)]
        found.append([entry + arb(0, inner(row, each).abs_upper()) for entry, row in zip(column, miss, strict=True)])
    return arb_mat(found).transpose()


def _largest(values: list[arb]) -> arb:
    """Bound the largest absolute value."""
    largest = arb(0)
    for value in values:
        largest = largest.max(value.abs_upper())
    return largest


def _times(A: MatrixSeries, B: MatrixSeries) -> MatrixSeries:
    products = [[A[k] * B[n - k] for k in range(n + 1)] for n in range(_ORDERS)]
    return [sum(parts[1:], parts[0]) for parts in products]


def _scaled(factor: arb_series, A: MatrixSeries) -> MatrixSeries:
    products = [[A[n - k] * factor[k] for k in range(n + 1)] for n in range(_ORDERS)]
    return [sum(parts[1:], parts[0]) for parts in products]


def _plus(A: MatrixSeries, B: MatrixSeries) -> MatrixSeries:
    return [one + other for one, other in zip(A, B, strict=True)]


def _minus(A: MatrixSeries, B: MatrixSeries) -> MatrixSeries:
    return [one - other for one, other in zip(A, B, strict=True)]


def _least_eigenvalue(M: FloatArray) -> arb:
    """Bound the least eigenvalue of a symmetric matrix of floats: it is not below the ball.

    With V nearly orthogonal and e = ||1 - V' V||_inf < 1, x = V y gives x' M x >= g |y|^2 for the least end g of
    Gershgorin's circles of V' M V, and |x|^2 is within (1 -/+ e) |y|^2.
    """
    V = ball_matrix(np.linalg.eigh(M)[1])
    A = V.transpose() * ball_matrix(M) * V
    loss = _largest([sum(row, arb(0)) for row in magnitudes(V.transpose() * V - ball_matrix(np.eye(len(M))))])
    least = arb("inf")
    for k, row in enumerate(magnitudes(A)):
        least = least.min(A[k, k] - sum((size for j, size in enumerate(row) if j != k), arb(0)))
    return least / arb(1, loss) if loss < 1 else arb("-inf")
