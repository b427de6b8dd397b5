"""Actuators that are not where they are commanded: their errors as symbols of a box, and what they add to its image.

With actuators off by a, the closures are, exactly,

    f(x; a) = f(x) + V(x) a + W(a),    V = df/dq,    W_l = |d|^2 a_c^2 / 2 - a_t^2 / 2,

c the cart of link l, d its rail, and t its telescope if it is one: V_lc = -v_l . d, V_lt = -len_l. With P near
-J^-1 V, C near J^-1, and x = x(t) + C e + P a + w, this adds

    |C (J P + V)| A + sum |a' (P' (G_i P / 2 + K_i) + diag(C_i W'') / 2) a| + |C' (G_i P + K_i)| (E, A)

to k_i and |G_i P + K_i| A to row i of Q, where column a of K_i is sum_l C_il dV_la/dx, and |a_k| <= A_k.

The errors may vary with time: a box holds exactly one regular pose for every s and every a, so that the pose is one
continuous function of both.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat, arb_series

from pipeline.arrays import FloatArray
from pipeline.inclusion.closure import Closure, Geometry, closure, component, cross
from pipeline.inclusion.matrices import (
    added,
    ball_matrix,
    floats,
    magnitudes,
    times,
    upper_bounds,
)
from pipeline.machine.geometry import ACTUATORS, ARM_OF_LINK, TELESCOPES

_LINKS, _ACTUATORS, _ORDERS = 6, len(ACTUATORS), 3
CARTS = [int(arm) for arm in ARM_OF_LINK]
TELESCOPE = {int(link): 3 + k for k, link in enumerate(TELESCOPES)}
_PAIRS = [(a, b) for a in range(_ACTUATORS) for b in range(a + 1)]
"""Pairs of actuators, whatever their order."""


@dataclass(frozen=True, eq=False)
class Following:
    """The actuators' errors as symbols of a box.

    Attributes
    ----------
    matrix : (2, 6, 5)
        P0 and P1: to first order the pose moves by P(t) a.
    over : 6 x 5 balls
        P(t) over the interval.
    errors : (5,) balls
        A.
    moved : (6,) balls
        |P| A.
    miss : (6,) balls
        |C (J P + V)| A.
    """

    matrix: FloatArray
    over: arb_mat
    errors: list[arb]
    moved: list[arb]
    miss: list[arb]

    @property
    def any(self) -> bool:
        """Whether any actuator is off."""
        return any(error > 0 for error in self.errors)

    def change(self, offset: arb, other: "Following") -> list[arb]:
        """Bound |P(offset) - P'| A against another box's P' at a single s."""
        if not other.any:
            return [arb(0)] * _LINKS
        here = ball_matrix(self.matrix[0]) + ball_matrix(self.matrix[1]) * offset
        return times(magnitudes(here - ball_matrix(other.matrix[0])), other.errors)


def slopes(C: arb_mat, hull: Closure[arb]) -> arb_mat:
    """Enclose K_i of all six coordinates over a box, one below the other: 36 x 5."""
    by_link = arb_mat(_LINKS, _LINKS * _ACTUATORS)
    for link, cart in enumerate(CARTS):
        rail = hull.rails[link]
        for k in range(3):
            by_link[link, _ACTUATORS * k + cart] = -rail[k]
        for j, axis in enumerate(hull.axes):
            by_link[link, _ACTUATORS * (3 + j) + cart] = -component(cross(axis, hull.arms[link]), rail)
    return arb_mat(_LINKS * _LINKS, _ACTUATORS, (C * by_link).entries())


def second_order(C: arb_mat, P: arb_mat, stacked: arb_mat, hull: Closure[arb]) -> FloatArray:
    """Bound twice the symmetric parts of P' (G_i P / 2 + K_i) + diag(C_i W'') / 2, entry by entry, shape (6, 5, 5).

    `stacked` holds G_i P / 2 + K_i of all six coordinates, one below the other: 36 x 5.
    """
    rows, n = stacked.table(), _ACTUATORS
    beside = arb_mat([[entry for i in range(_LINKS) for entry in rows[_LINKS * i + k]] for k in range(_LINKS)])
    M, bent = (P.transpose() * beside).table(), (C * _squares(hull)).table()
    upper = arb_mat(
        [[M[a][n * i + b] + M[b][n * i + a] + (bent[i][a] if a == b else 0) for a, b in _PAIRS] for i in range(_LINKS)]
    )
    bounds, (first, second) = np.empty((_LINKS, n, n)), np.array(_PAIRS).T
    bounds[:, first, second] = bounds[:, second, first] = upper_bounds(upper)
    return bounds


def _squares(hull: Closure[arb]) -> arb_mat:
    """Compute W'' of each link by each actuator, 6 x 5."""
    squares = arb_mat(_LINKS, _ACTUATORS)
    for link, rail in enumerate(hull.rails):
        squares[link, CARTS[link]] = component(rail, rail)
        if link in TELESCOPE:
            squares[link, TELESCOPE[link]] = -1
    return squares


_NOTHING = [arb(0)] * _LINKS
NO_FOLLOWING = Following(
    np.zeros((2, _LINKS, _ACTUATORS)), arb_mat(_LINKS, _ACTUATORS), [arb(0)] * _ACTUATORS, _NOTHING, _NOTHING
)
"""Every actuator is where it is commanded."""


@dataclass(frozen=True, eq=False)
class Symbols:
    """What does not depend on the size of the errors.

    Attributes
    ----------
    matrix : (2, 6, 5)
        P0 and P1.
    over : 6 x 5 balls
        P(t) over the interval.
    size : 6 x 5 bounds
        |P|.
    miss : 6 x 5 bounds
        |C (J P + V)|.
    """

    matrix: FloatArray
    over: arb_mat
    size: list[list[arb]]
    miss: list[list[arb]]


def choose_symbols(
    closures: tuple[Closure[arb_series], Closure[arb_series]], inverse: FloatArray, J: list[arb_mat], h: arb
) -> Symbols:
    """Choose P over an interval of half-width h, from the closures about its middle and about every t, C and J."""
    at, over = closures
    V = [_rates(at, 0), _rates(at, 1), _rates(over, 2)]
    V0, V1 = floats(V[0]), floats(V[1])
    matrix = np.stack([-inverse[0] @ V0, -(inverse[0] @ V1 + inverse[1] @ V0)])
    P, C = ([ball_matrix(part) for part in parts] for parts in (matrix, inverse))
    rest = [
        J[0] * P[0] + V[0],
        J[0] * P[1] + J[1] * P[0] + V[1],
        J[1] * P[1] + J[2] * P[0] + V[2],
        J[2] * P[1],
    ]
    miss = [[arb(0)] * _ACTUATORS for _ in range(_LINKS)]
    for power, part in enumerate(C):
        for n, term in enumerate(rest):
            scale = h ** (n + power)
            sizes = magnitudes(part * term)
            miss = [
                [total + size * scale for total, size in zip(*rows, strict=True)]
                for rows in zip(miss, sizes, strict=True)
            ]
    everywhere = P[0] + P[1] * arb(0, h)
    return Symbols(matrix, everywhere, magnitudes(everywhere), miss)


def follow_actuators(symbols: Symbols, errors_m: tuple[float, ...]) -> Following:
    """Give actuators errors of up to `errors_m` (5,), at least one of them not zero."""
    A = [arb(e) for e in errors_m]
    return Following(symbols.matrix, symbols.over, A, times(symbols.size, A), times(symbols.miss, A))


@dataclass(frozen=True, eq=False)
class Erring:
    """What bounds need where actuators are off.

    Attributes
    ----------
    following : Following
        P and A.
    hull : Closure
        The closures over all proven poses and all errors of the actuators, in plain balls.
    """

    following: Following
    hull: Closure[arb]


def erring(machine: Geometry, over: Closure[arb_series], following: Following, deviation: list[arb]) -> Erring | None:
    """Evaluate the closures over poses within `deviation` (6,) of x(t) + P a for all errors; None if there are none."""
    if not following.any:
        return None
    reach = added(following.moved, deviation)
    pose = [coordinate[0] + arb(0, r.upper()) for coordinate, r in zip(over.pose, reach, strict=True)]
    q = [position[0] + arb(0, e) for position, e in zip(over.q, following.errors, strict=True)]
    return Erring(following, closure(machine, pose, q))


def joint_moves(errors: Erring) -> list[arb_mat]:
    """Enclose the derivatives of all end points by the error of each actuator: five matrices 3 x 15.

    Cart joints move by d with their own cart; platform joints by P_xyz + T P_angles, T the axes crossed with the arm.
    """
    table = errors.following.over.table()
    shift, turn = arb_mat(table[:3]), arb_mat(table[3:])
    platform = [
        shift + arb_mat([cross(axis, arm) for axis in errors.hull.axes]).transpose() * turn for arm in errors.hull.arms
    ]
    still, found = [arb(0)] * 3, []
    for k in range(len(errors.following.errors)):
        carts = [rail if cart == k else still for cart, rail in zip(CARTS, errors.hull.rails, strict=True)]
        points = [*carts, *([joint[c, k] for c in range(3)] for joint in platform), still, still, still]
        found.append(arb_mat(points).transpose())
    return found


def _rates(closure: Closure[arb_series], order: int) -> arb_mat:
    """Return a coefficient of V as a series, 6 x 5."""
    V = arb_mat(_LINKS, _ACTUATORS)
    for link, along in enumerate(closure.along_rails()):
        V[link, CARTS[link]] = -along[order]
        if link in TELESCOPE:
            V[link, TELESCOPE[link]] = -closure.lengths[link][order]
    return V
