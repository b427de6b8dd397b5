"""Actuators that are not where they are commanded: their errors as symbols of a box, and what they add to its image.

With actuators off by a, the closures are, exactly,

    f(x; a) = f(x) + V(x) a + W(a),    V = df/dq,    W_l = a_c^2 / 2 - a_t^2 / 2,

c the cart of link l, and t its telescope if it is one: V_lc = -(v_l)_x, V_lt = -len_l. With P near -J^-1 V, C near
J^-1, and x = x(t) + C e + P a + w, this adds

    |C (J P + V)| A + sum |a' (P' (G_i P / 2 + K_i) + diag(C_i W'') / 2) a| + |C' (G_i P + K_i)| (E, A)

to k_i and |G_i P + K_i| A to row i of Q, where column a of K_i is sum_l C_il dV_la/dx, and |a_k| <= A_k.

The errors may vary with time: a box holds exactly one regular pose for every s and every a, so that the pose is one
continuous function of both.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat, arb_series

from pipeline.arrays import FloatArray
from pipeline.inclusion.closure import Closure, cross
from pipeline.inclusion.matrices import added, ball_matrix, floats, magnitudes, times
from pipeline.machine.geometry import ACTUATORS, ARM_OF_LINK, TELESCOPES

_LINKS, _ACTUATORS, _ORDERS = 6, len(ACTUATORS), 3
_CARTS = [int(arm) for arm in ARM_OF_LINK]
_TELESCOPE = {int(link): 3 + k for k, link in enumerate(TELESCOPES)}


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

    def slopes(self, C: arb_mat, hull: Closure[arb]) -> list[arb_mat]:
        """Enclose K_i (6 x 5) of all six coordinates over a box."""
        if not self.any:
            return []
        by_link = []
        for link in range(_LINKS):
            turned = [cross(axis, hull.arms[link])[0] for axis in hull.axes]
            by_link.append([arb(-1), arb(0), arb(0), *(-x for x in turned)])
        found = []
        for i in range(_LINKS):
            K = arb_mat(_LINKS, _ACTUATORS)
            for link, row in enumerate(by_link):
                for coordinate, slope in enumerate(row):
                    K[coordinate, _CARTS[link]] += C[i, link] * slope
            found.append(K)
        return found

    def second_order(self, i: int, C: arb_mat, G: arb_mat, K: arb_mat) -> arb:
        """Bound |a' (P' (G_i P / 2 + K_i) + diag(C_i W'') / 2) a| for all errors."""
        M = self.over.transpose() * (G * self.over / 2 + K)
        for link in range(_LINKS):
            M[_CARTS[link], _CARTS[link]] += C[i, link] / 2
            if link in _TELESCOPE:
                M[_TELESCOPE[link], _TELESCOPE[link]] -= C[i, link] / 2
        total = arb(0)
        for a in range(_ACTUATORS):
            total += M[a, a].abs_upper() * self.errors[a] ** 2
            for b in range(a):
                total += (M[a, b] + M[b, a]).abs_upper() * self.errors[a] * self.errors[b]
        return total

    def change(self, offset: arb, other: "Following") -> list[arb]:
        """Bound |P(offset) - P'| A against another box's P' at a single s."""
        if not other.any:
            return [arb(0)] * _LINKS
        here = ball_matrix(self.matrix[0]) + ball_matrix(self.matrix[1]) * offset
        return times(magnitudes(here - ball_matrix(other.matrix[0])), other.errors)


_NOTHING = [arb(0)] * _LINKS
NO_FOLLOWING = Following(
    np.zeros((2, _LINKS, _ACTUATORS)), arb_mat(_LINKS, _ACTUATORS), [arb(0)] * _ACTUATORS, _NOTHING, _NOTHING
)
"""Every actuator is where it is commanded."""


def follow_actuators(
    closures: tuple[Closure[arb_series], Closure[arb_series]],
    inverse: FloatArray,
    J: list[arb_mat],
    h: arb,
    errors_m: tuple[float, ...],
) -> Following:
    """Choose P over an interval of half-width h, from the closures about its middle and about every t, C and J."""
    if not any(errors_m):
        return NO_FOLLOWING
    at, over = closures
    V = [_rates(at, 0), _rates(at, 1), _rates(over, 2)]
    V0, V1 = floats(V[0]), floats(V[1])
    matrix = np.stack([-inverse[0] @ V0, -(inverse[0] @ V1 + inverse[1] @ V0)])
    P, C, A = (
        [ball_matrix(part) for part in matrix],
        [ball_matrix(part) for part in inverse],
        [arb(e) for e in errors_m],
    )
    rest = [
        J[0] * P[0] + V[0],
        J[0] * P[1] + J[1] * P[0] + V[1],
        J[1] * P[1] + J[2] * P[0] + V[2],
        J[2] * P[1],
    ]
    miss = [arb(0)] * _LINKS
    for power, part in enumerate(C):
        for n, term in enumerate(rest):
            scale = h ** (n + power)
            miss = added(miss, [bound * scale for bound in times(magnitudes(part * term), A)])
    everywhere = P[0] + P[1] * arb(0, h)
    return Following(matrix, everywhere, A, times(magnitudes(everywhere), A), miss)


def _rates(closure: Closure[arb_series], order: int) -> arb_mat:
    """Return a coefficient of V as a series, 6 x 5."""
    V = arb_mat(_LINKS, _ACTUATORS)
    for link in range(_LINKS):
        V[link, _CARTS[link]] = -closure.vectors[link][0][order]
        if link in _TELESCOPE:
            V[link, _TELESCOPE[link]] = -closure.lengths[link][order]
    return V
