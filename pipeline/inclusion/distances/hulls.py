"""Rigorous lower bounds of the distances of moving hulls of points, for many pairs at a time, by separating directions.

For any n(t), two hulls are at least min n . (a - b) / |n| apart over all pairs of their points a, b. The direction is
linear in t, from the shortest connections at both ends of the interval; where that shows too little, a constant one is
tried. Any direction gives a valid bound.

Where actuators are off by e, |e_k| <= A_k, points move by sum e_k S_k with derivatives S_k, and directions turn with
them, n = N(t) + sum e_k M_k. With D = a - b without errors,

    n . (a - b) >= N . D - sum |N . S_k + M_k . D| A_k - (sum |M_k| A_k) (sum |S_k| A_k).

Coefficients are balls, in floats. What floats lose is bounded beforehand: no entry takes more than 60 operations, each
of which loses at most 2^-53 of a magnitude that is computed.
"""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.inclusion.matrices import enlarged
from pipeline.machine.shapes.gjk import hull_separation

LOST = 1e-13
"""Part of the largest magnitude that floats lose at most in a bound: ten times 60 roundings."""
_PROBE_M, _FASTEST_PER_M = 1e-4, 1e3


@dataclass(frozen=True, eq=False)
class MovingHulls:
    """The points of hulls over an interval, one hull of each pair.

    Attributes
    ----------
    middle, radius : (orders, pairs, k, 3)
        Coefficients of order 0, 1 and 2 in t, along x(t).
    off : (pairs,)
        How far a point is off them at most, but for the errors of actuators.
    moves, moves_radius : (5, pairs, k, 3)
        S_k over the interval; (0, pairs, k, 3) where no actuator is off.
    """

    middle: FloatArray
    radius: FloatArray
    off: FloatArray
    moves: FloatArray
    moves_radius: FloatArray

    def at(self, t: float) -> FloatArray:
        """Evaluate the middles, shape (k, 3, pairs)."""
        value = self.middle[0] + t * self.middle[1] + t * t * self.middle[2]
        return np.ascontiguousarray(np.moveaxis(value, 0, -1))

    def moved(self, by_m: float) -> FloatArray:
        """Move the middles of t = 0 by an error of each actuator, shape (k, 3, 5 pairs)."""
        value = (self.middle[0] + by_m * self.moves).reshape(-1, *self.middle.shape[2:])
        return np.ascontiguousarray(np.moveaxis(value, 0, -1))

    def size(self, half: float) -> FloatArray:
        """Bound coordinates over |t| <= half, shape (pairs, k, 3)."""
        return enlarged(sum((half**k * part for k, part in enumerate(np.abs(self.middle) + self.radius)), np.zeros(1)))


@dataclass(frozen=True, eq=False)
class Directions:
    """Directions n0 + n1 t + sum e_k M_k of all pairs: (pairs, 3) twice, and (5, pairs, 3)."""

    mean: FloatArray
    slope: FloatArray
    turning: FloatArray

    def at(self, t: float) -> FloatArray:
        """Evaluate them without errors, shape (pairs, 3)."""
        return np.asarray(self.mean + t * self.slope, dtype=float)


def separating_directions(first: MovingHulls, second: MovingHulls, half: float) -> Directions:
    """Choose directions from the shortest connections; no proof relies on them."""
    before, after = (hull_separation(first.at(t), second.at(t)).normal.T for t in (-half, half))
    slope = (after - before) / (2.0 * half) if half > 0.0 else np.zeros_like(before)
    turning = np.zeros((len(first.moves), *slope.shape))
    if turning.size:
        back, forth = (hull_separation(first.moved(by), second.moved(by)).normal.T for by in (-_PROBE_M, _PROBE_M))
        turning = ((forth - back) / (2.0 * _PROBE_M)).reshape(turning.shape)
        # Where closest points change from one corner to another, directions jump.
        turning[np.linalg.norm(turning, axis=-1) > _FASTEST_PER_M] = 0.0
    return Directions((before + after) / 2.0, slope, turning)


def separated(
    first: MovingHulls, second: MovingHulls, directions: Directions, half: float, errors_m: FloatArray
) -> FloatArray:
    """Bound the distances of pairs of hulls from below over |t| <= half, and errors of up to (5,). Shape (pairs,).

    Negative if nothing is known.
    """
    still = replace(directions, slope=0.0 * directions.slope, turning=0.0 * directions.turning)
    tried = [_bound(first, second, n, half, errors_m) for n in (directions, still)]
    return np.asarray(np.maximum(*tried) - (first.off + second.off), dtype=float)


def _bound(first: MovingHulls, second: MovingHulls, n: Directions, half: float, errors_m: FloatArray) -> FloatArray:
    """Bound min n . (a - b) / |n| from below, without what points are off. Shape (pairs,)."""
    middles, radii = [], []
    for moving in (first, second):
        middle, radius = _heights(moving, n)
        middles.append(middle)
        radii.append(radius)
    gap = [a[:, :, None] - b[:, None] for a, b in zip(*middles, strict=True)]
    width = [a[:, :, None] + b[:, None] for a, b in zip(*radii, strict=True)]
    least = gap[0] - width[0]
    size = np.abs(gap[0]) + width[0]
    for order in range(1, len(gap)):
        spread = half**order * (np.abs(gap[order]) + width[order])
        least, size = least - spread, size + spread
    reach = [sum(half**k * np.abs(part).max(axis=(1, 2)) for k, part in enumerate(m.middle)) for m in (first, second)]
    length = np.maximum(*(np.linalg.norm(n.at(t), axis=1) for t in (-half, half)))
    if errors_m.any():
        least, length = least - _closer(first, second, n, half, errors_m), _longer(n, length, half, errors_m)
    most = 3.0 * (reach[0] + reach[1]) * (np.abs(n.mean) + half * np.abs(n.slope)).max(axis=1)
    least = least.min(axis=(1, 2)) - LOST * (1.0 + most + size.max(axis=(1, 2)))
    return np.where((length > 0.0) & (least > 0.0), least / np.maximum(length * (1.0 + LOST), 1e-300), -1.0)


def _heights(moving: MovingHulls, n: Directions) -> tuple[list[FloatArray], list[FloatArray]]:
    """Compute the coefficients of n . a of order 0 to 3 in t, middles and radii (pairs, k) each."""
    p, r = moving.middle, moving.radius
    middles = [
        _dot(n.mean, p[0]),
        _dot(n.mean, p[1]) + _dot(n.slope, p[0]),
        _dot(n.mean, p[2]) + _dot(n.slope, p[1]),
        _dot(n.slope, p[2]),
    ]
    mean, slope = np.abs(n.mean), np.abs(n.slope)
    radii = [
        _dot(mean, r[0]),
        _dot(mean, r[1]) + _dot(slope, r[0]),
        _dot(mean, r[2]) + _dot(slope, r[1]),
        _dot(slope, r[2]),
    ]
    return middles, radii


def _closer(first: MovingHulls, second: MovingHulls, n: Directions, half: float, errors_m: FloatArray) -> FloatArray:
    """Bound by how much n . (a - b) becomes smaller with the errors, shape (pairs, k, l)."""
    sizes = [moving.size(half) for moving in (first, second)]
    turned, linear, apart = np.zeros(len(n.mean)), np.zeros(1), np.zeros(1)
    for k in np.flatnonzero(errors_m).tolist():
        M, A = n.turning[k], errors_m[k]
        (a, a_radius), (b, b_radius) = (
            _changes(moving, n, k, half, size) for moving, size in zip((first, second), sizes, strict=True)
        )
        linear = linear + A * (np.abs(a[:, :, None] - b[:, None]) + a_radius[:, :, None] + b_radius[:, None])
        between = np.abs(first.moves[k][:, :, None] - second.moves[k][:, None])
        between = between + first.moves_radius[k][:, :, None] + second.moves_radius[k][:, None]
        apart = apart + A * np.linalg.norm(between, axis=-1)
        turned = turned + A * np.linalg.norm(M, axis=1)
    return enlarged(linear + turned[:, None, None] * apart)


def _changes(
    moving: MovingHulls, n: Directions, k: int, half: float, size: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Enclose N . S_k + M_k . a over |t| <= half, middles and radii (pairs, points)."""
    M, S, radius = n.turning[k], moving.moves[k], moving.moves_radius[k]
    middle = _dot(n.mean, S) + _dot(M, moving.middle[0])
    beside = size - np.abs(moving.middle[0]) + LOST * size
    sizes = np.abs(n.mean), half * np.abs(n.slope), np.abs(M)
    spread = _dot(sizes[0], radius) + _dot(sizes[1], np.abs(S) + radius) + _dot(sizes[2], beside)
    return middle, spread + LOST * (_dot(sizes[0], np.abs(S)) + _dot(sizes[2], size))


def _longer(n: Directions, length: FloatArray, half: float, errors_m: FloatArray) -> FloatArray:
    """Bound |n| for all errors, where it is up to `length` (pairs,) without: |n|^2 + 2 |N . e M| + |e M|^2."""
    ends = np.maximum(*(np.abs(np.einsum("pc,epc->ep", n.at(t), n.turning)) for t in (-half, half)))
    each = np.linalg.norm(n.turning, axis=2)
    along, turned = errors_m @ (ends + LOST * length * each), errors_m @ each
    return np.asarray(enlarged(np.sqrt(length**2 + 2.0 * along + turned**2)), dtype=float)


def _dot(normal: FloatArray, points: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("pc,pkc->pk", normal, points), dtype=float)
