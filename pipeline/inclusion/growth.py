"""How the image of a box grows with its radii: what decides whether radii can be found for which the box is proven.

With the bounds of `pipeline.inclusion.krawczyk`, for radii r up to those that a hull was taken of,

    k_i(r) = c_i + sum_j (Q_ij + sum_l G_ijl r_l) r_j.

Sums of bounds are in floats; `enlarged` covers what they round.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat

from pipeline.arrays import FloatArray
from pipeline.inclusion.closure import Closure, second_derivatives
from pipeline.inclusion.following import Following, Symbols, second_order, slopes
from pipeline.inclusion.matrices import enlarged, upper_bounds, upper_vector

_SIZE = 6
_STEPS, _SETTLED = 20, 1e-3
_ATTEMPTS_WITH_ERRORS = 6
_INFLATION, _ROOM, _ROOM_FOR_JOINTS, _LESS_ROOM = 1.5, 1.03, 1.2, (1.2, 1.1, 1.05, 1.02, 1.003)
"""How much larger than its image a box is made; how much larger than what suffices to first order, with errors of
actuators and without: a large share of the radii has to hold the joints, too."""
LEAST_RADIUS = 1e-6
"""Least radius of a box in metres and radians, so that neighbours overlap despite rounding."""


@dataclass(frozen=True, eq=False)
class Growth:
    """Bounds of k = constant + linear r + quadratic (r, r): (6,), (6, 6), (6, 6, 6), none negative."""

    constant: FloatArray
    linear: FloatArray
    quadratic: FloatArray

    def image(self, radius: FloatArray) -> list[arb]:
        """Bound k for radii (6,)."""
        return [arb(value) for value in enlarged(self._at(radius)).tolist()]

    def radius(self, share: float) -> FloatArray | None:
        """Estimate the least radii (6,) of which k takes up a share; None if there are none. No proof relies on it.

        Newton's method from zero: k is convex and grows with r, so that its iterates grow towards the least solution.
        """
        radius, identity = np.zeros(_SIZE), np.eye(_SIZE)
        for _ in range(_STEPS):
            off = self._at(radius) / share - radius
            if not (np.isfinite(off).all() and (radius < 1.0).all()):
                return None
            if (off <= _SETTLED * radius).all():
                return radius
            try:
                step = np.linalg.solve(identity - (self.linear + 2.0 * self.quadratic @ radius) / share, off)
            except np.linalg.LinAlgError:
                return None
            if not (step >= 0.0).all():
                return None
            radius = radius + step
        return None

    def times(self, radius: FloatArray, image: list[arb]) -> float:
        """Estimate how many times as large an image (6,) is as this growth says for its radii."""
        return float(np.max(upper_vector(image) / np.maximum(self._at(radius), 1e-300)))

    def _at(self, radius: FloatArray) -> FloatArray:
        return np.asarray(self.constant + (self.linear + self.quadratic @ radius) @ radius, dtype=float)


@dataclass(frozen=True, eq=False)
class Known:
    """What bounds of an image need beside the hull.

    |I - C J|, what k is made of without radii, E, |x - x(t)|, and |C dJ|.
    """

    miss: list[list[arb]]
    rest: list[arb]
    residual_change: list[arb]
    moved: list[arb]
    jacobian_change: list[list[arb]]


def growth(C: arb_mat, hull: Closure[arb], known: Known, following: Following, radius: FloatArray) -> Growth:
    """Bound how k of a box depends on its radii, up to those (6,) that its hull was taken of."""
    miss, D = (np.array([upper_vector(row) for row in matrix]) for matrix in (known.miss, known.jacobian_change))
    constant, E, moved = (upper_vector(values) for values in (known.rest, known.residual_change, known.moved))
    G, linear = _second(C, hull), miss
    if uncertain := any(not e.is_zero() for e in known.residual_change):
        GC, CT = G * C, C.transpose()
        linear = linear + _bounds(GC) @ E
        constant = constant + np.array([E @ upper_bounds(CT * part) @ E for part in _parts(GC)]) / 2.0
        constant += D @ (moved + radius)
    if following.any:
        A, K, GP = upper_vector(following.errors), slopes(C, hull), G * following.over
        bent = GP + K
        linear = linear + _bounds(bent) @ A
        constant = constant + second_order(C, following.over, GP / 2 + K, hull) @ A @ A / 2.0
        if uncertain:
            constant += np.array([E @ upper_bounds(CT * part) @ A for part in _parts(bent)])
    return Growth(constant, linear, _bounds(G))


@dataclass(frozen=True, eq=False)
class Outline:
    """The growth of a box without its hull, for any errors of the actuators: with the hull k is no smaller.

    Attributes
    ----------
    own, miss, symbols_miss : (6,), (6, 6), (6, 5)
        |C f|, |I - C J| and |C (J P + V)|.
    second, slope, quadratic : (6, 5, 5), (6, 6, 5), (6, 6, 6)
        What multiplies (A, A) / 2, (r, A) and (r, r).
    """

    own: FloatArray
    miss: FloatArray
    symbols_miss: FloatArray
    second: FloatArray
    slope: FloatArray
    quadratic: FloatArray

    def of(self, errors_m: tuple[float, ...], widening: float = 1.0) -> Growth:
        """Give the growth for errors (5,) of the actuators, if the hull makes it `widening` times as large."""
        A = np.array(errors_m)
        constant = self.own + self.symbols_miss @ A + self.second @ A @ A / 2.0
        linear = self.miss + self.slope @ A
        return Growth(widening * constant, widening * linear, widening * self.quadratic)


def outline(C: arb_mat, along: Closure[arb], misses: tuple[list[list[arb]], list[arb]], symbols: Symbols) -> Outline:
    """Bound how k depends on radii and errors of the actuators, with the closures along x(t) alone."""
    miss, missed = (np.array([upper_vector(row) for row in matrix]) for matrix in (misses[0], symbols.miss))
    G, K = _second(C, along), slopes(C, along)
    GP = G * symbols.over
    second = second_order(C, symbols.over, GP / 2 + K, along)
    return Outline(upper_vector(misses[1]), miss, missed, second, _bounds(GP + K), _bounds(G))


def _second(C: arb_mat, hull: Closure[arb]) -> arb_mat:
    """Enclose G_i = sum_l C_il f_l'' of all six coordinates, one below the other: 36 x 6."""
    return arb_mat(_SIZE * _SIZE, _SIZE, (C * arb_mat(second_derivatives(hull))).entries())


def _parts(stacked: arb_mat) -> list[arb_mat]:
    """Split six matrices with six rows each that are stacked, one per coordinate of the pose."""
    entries, n = stacked.entries(), _SIZE * stacked.ncols()
    return [arb_mat(_SIZE, stacked.ncols(), entries[n * i : n * (i + 1)]) for i in range(_SIZE)]


def _bounds(stacked: arb_mat) -> FloatArray:
    """Bound the entries of six stacked matrices, shape (6, 6, n)."""
    return upper_bounds(stacked).reshape(_SIZE, _SIZE, stacked.ncols())


_Grow = Callable[[FloatArray], tuple[Growth, list[list[arb]]]]
"""Gives how k grows up to some radii (6,), and |C dJ|."""
_Found = tuple[FloatArray, list[arb], list[list[arb]]]
"""Radii (6,) that suffice, the image k, and |C dJ|."""


def enlarge(radius: FloatArray, grow: _Grow, slack: arb, attempts: int) -> _Found | None:
    """Make radii (6,) larger than the image, again and again, until a share `slack` of them suffices."""
    for _ in range(attempts):
        grown, D = grow(radius)
        image = grown.image(radius)
        if _suffices(image, radius, slack):
            return radius, image, D
        if not all(k.is_finite() and k < 1 for k in image):
            return None
        radius = _at_least(radius, _INFLATION * upper_vector(image))
    return None


def settle(given: tuple[FloatArray, FloatArray], grow: _Grow, likely: Sequence[Growth], slack: arb) -> _Found | None:
    """Find the least radii (6,) of which a share `slack` suffices: near the largest errors few do.

    They are not below the first of those given, and sought from the second on.

    Each hull shows how k grows with the radii up to its own. What it is likely to show says where to begin; the last of
    these is certain: the hull only adds to it.
    """
    (floor, radius), share, room, spare = given, float(slack), _ROOM if likely else _ROOM_FOR_JOINTS, None
    if likely:
        if (spare := likely[-1].radius(share)) is None:
            return None
        if (radius == floor).all():
            first = likely[0].radius(share / room)
            radius = _at_least(floor, spare if first is None else first)
    for attempt in range(1, _ATTEMPTS_WITH_ERRORS + 1):
        grown, D = grow(radius)
        if _suffices(image := grown.image(radius), radius, slack):
            # What holds for these radii holds for smaller ones: less is lost in what is bounded over the box.
            if (less := grown.radius(share / room)) is not None:
                less = np.minimum(radius, _at_least(floor, less))
                if _suffices(smaller := grown.image(less), less, slack):
                    return less, smaller, D
            return radius, image, D
        tried = (grown.radius(share / more) for more in (room**attempt, *_LESS_ROOM))
        if (wider := next((radius for radius in tried if radius is not None), None)) is None:
            # Radii that were too large widened the hull.
            wider, spare = spare, None
        if wider is None:
            return None
        radius = _at_least(floor, wider)
    return None


def _suffices(image: list[arb], radius: FloatArray, slack: arb) -> bool:
    return all(k < arb(r) * slack for k, r in zip(image, radius.tolist(), strict=True))


def _at_least(floor: FloatArray, radius: FloatArray) -> FloatArray:
    return np.asarray(np.maximum(np.maximum(radius, LEAST_RADIUS), floor), dtype=float)
