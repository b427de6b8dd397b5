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

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeVar, cast

import numpy as np
from flint import arb, arb_mat, arb_series

from pipeline.arrays import FloatArray
from pipeline.inclusion.calibrated.closures import preconditioned_change
from pipeline.inclusion.closure import (
    TERMS,
    Closure,
    Geometry,
    closure,
    pose_series,
    shifted,
)
from pipeline.inclusion.following import NO_FOLLOWING, Following, Symbols, choose_symbols, follow_actuators
from pipeline.inclusion.growth import LEAST_RADIUS, Growth, Known, Outline, enlarge, growth, outline, settle
from pipeline.inclusion.matrices import added, ball_matrix, floats, magnitudes, matrices, times
from pipeline.inclusion.pieces import Piece, middle
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty, jacobian_change, residual_change

_T = TypeVar("_T")
_SIZE = 6
_ATTEMPTS = 3
SLACK, _SLACK_WITH_ERRORS = arb(0.95), arb(0.9)
"""Share of a radius that has to suffice, so that other arithmetic with wider enclosures can verify the same boxes; with
errors of actuators enclosures are wider still."""


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
        |C| D, or for the machines of an ellipsoid a bound of |C dJ| that is smaller.
    following : Following
        P and A.
    widening : float
        How many times as large k is as without the hull: about as much as that of neighbouring boxes.
    """

    box: Box
    inverse: FloatArray
    image: list[arb]
    residual_change: list[arb]
    jacobian_change: list[list[arb]]
    following: Following = NO_FOLLOWING
    widening: float = 1.0


@dataclass(frozen=True, eq=False)
class Piecewise:
    """The closures along x(t): series about the middle of the interval, and series about every t in it.

    What follows from them for any uncertainty is computed once, when first asked for.
    """

    half: arb
    at: Closure[arb_series]
    over: Closure[arb_series]
    _derived: dict[Hashable, Any] = field(default_factory=dict, repr=False)

    def derive(self, key: Hashable, compute: Callable[[], _T]) -> _T:
        """Give what is known by a key, computed once."""
        if key not in self._derived:
            self._derived[key] = compute()
        return cast("_T", self._derived[key])

    @cached_property
    def jacobian(self) -> list[arb_mat]:
        """J0, J1, and J2 over the interval."""
        return matrices(self.at.jacobian(), self.over.jacobian(), 3)

    @cached_property
    def inverse(self) -> FloatArray | None:
        """C0 and C1, shape (2, 6, 6); None if J0 is numerically singular."""
        return linear_inverse(self.jacobian)

    @cached_property
    def symbols(self) -> Symbols | None:
        """P and what it misses; None without an inverse."""
        if self.inverse is None:
            return None
        return choose_symbols((self.at, self.over), self.inverse, self.jacobian, self.half)

    @cached_property
    def misses(self) -> tuple[list[list[arb]], list[arb]]:
        """Bounds of |I - C J|, 6 x 6, and of |C f|, (6,), with an inverse."""
        assert self.inverse is not None
        C = [ball_matrix(part) for part in self.inverse]
        return residual_of_inverse(C, self.jacobian, self.half), _residual(C, self, self.half)


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
    machine: Geometry,
    series: Piecewise,
    box: Box,
    uncertainty: Uncertainty = CERTAIN,
    attempts: int = _ATTEMPTS,
    widening: float = 1.0,
) -> Inclusion | None:
    """Prove a box, with larger radii if its own are too small; None if that fails.

    With errors, those at a single s may become smaller, too: nothing has to fit into such a box.
    How many times as large the hull likely makes the image (`widening`) only decides which radii are tried first.
    """
    if (inverse := series.inverse) is None or (symbols := series.symbols) is None:
        return None
    C = [ball_matrix(part) for part in inverse]
    C_over = C[0] + C[1] * arb(0, series.half)
    C_abs = magnitudes(C_over)
    miss, own = series.misses
    E = residual_change(machine, series.over, uncertainty)
    following = follow_actuators(symbols, uncertainty.actuator_m) if any(uncertainty.actuator_m) else NO_FOLLOWING
    moved = added(times(C_abs, E), following.moved)
    rest = added(own, following.miss)
    if uncertainty.calibration:
        rest = added(rest, times(miss, times(C_abs, E)))

    def grow(radius: FloatArray) -> tuple[Growth, list[list[arb]]]:
        hull = _hull(machine, series, added(moved, [arb(value) for value in radius.tolist()]))
        D = _preconditioned(machine, hull, C_over, uncertainty)
        return growth(C_over, hull, Known(miss, rest, E, moved, D), following, radius), D

    def without_hull() -> Outline:
        return outline(C_over, _hull(machine, series), series.misses, symbols)

    floor = box.radius if box.first < box.last else np.full(_SIZE, LEAST_RADIUS)
    if not uncertainty.any:
        found = enlarge(box.radius, grow, SLACK, attempts)
    elif not following.any:
        found = settle((floor, box.radius), grow, [], SLACK)
    else:
        about = series.derive(Outline, without_hull)
        likely, least = (about.of(uncertainty.actuator_m, times) for times in (widening, 1.0))
        found = settle((floor, box.radius), grow, [likely, least], _SLACK_WITH_ERRORS)
        if found is not None:
            widening = least.times(*found[:2])
    if found is None:
        return None
    radius, image, D = found
    box = Box(box.first, box.last, box.pose, radius)
    return Inclusion(box, inverse, image, E, D, following, widening)


def _preconditioned(machine: Geometry, hull: Closure[arb], C: arb_mat, uncertainty: Uncertainty) -> list[list[arb]]:
    """Bound |C dJ| over all poses of a box. 6 x 6 bounds."""
    if uncertainty.ellipsoid is not None:
        return preconditioned_change(hull, C, uncertainty.ellipsoid)
    D = [list(column) for column in zip(*jacobian_change(machine, hull, uncertainty), strict=True)]
    return [list(row) for row in zip(*(times(magnitudes(C), column) for column in D), strict=True)]


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


def _hull(machine: Geometry, series: Piecewise, reach: Sequence[arb] = (arb(0),) * _SIZE) -> Closure[arb]:
    """Evaluate the closures over all poses within `reach` (6,) of x(t), in plain balls."""
    pose = [coordinate[0] + arb(0, r.upper()) for coordinate, r in zip(series.over.pose, reach, strict=True)]
    return closure(machine, pose, [q[0] for q in series.over.q])


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
