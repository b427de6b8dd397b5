"""Least distances of moving hulls over many boxes; the statement is that of `pipeline.inclusion.distances.hulls`."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import (
    Enclosure,
    bound,
    contract,
    dot,
    exactly,
    root,
    rounded_down,
    times,
    total,
    within,
)
from pipeline.certify.recheck.arithmetic.inclusion import power
from pipeline.certify.recheck.arithmetic.norms import norm
from pipeline.machine.shapes.gjk import hull_separation

_PROBE_M, _FASTEST_PER_M = 1e-4, 1e3
_ACROSS_X = np.array([0.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class MovingHull:
    """The points of a hull: coefficients (k, 3, n) of order 0 to 2, and S (k, 3, 5, n) where actuators are off."""

    points: Sequence[Enclosure]
    moves: Enclosure | None = None

    def at(self, t: FloatArray) -> FloatArray:
        """Evaluate the middles at t (n,), shape (k, 3, n)."""
        p = self.points
        return np.asarray(p[0].mid + t * p[1].mid + t * t * p[2].mid, dtype=float)

    def across_x(self) -> "MovingHull":
        """Leave out x."""
        points = [_scaled(part, _ACROSS_X[:, None]) for part in self.points]
        return MovingHull(points, None if self.moves is None else _scaled(self.moves, _ACROSS_X[:, None, None]))


@dataclass(frozen=True, eq=False)
class _Directions:
    """n0 and n1 (3, n), and M (3, 5, n) of n0 + n1 t + sum e_k M_k."""

    mean: Enclosure
    slope: Enclosure
    turning: Enclosure


def separated(first: MovingHull, second: MovingHull, h: FloatArray, errors_m: FloatArray) -> FloatArray:
    """Bound the distances of two hulls, for errors of actuators of up to (5, n); -1 if nothing is known. Shape (n,)."""
    tried = (_closest(first, second, n, h, errors_m) for n in _directions(first, second, h))
    return np.asarray(np.maximum(*tried), dtype=float)


def _directions(first: MovingHull, second: MovingHull, h: FloatArray) -> Iterator[_Directions]:
    """Choose directions that turn, and others that do not; they need not be right."""
    before, after = (hull_separation(first.at(t), second.at(t)).normal for t in (-h, h))
    mean = (before + after) / 2.0
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(h > 0.0, (after - before) / (2.0 * h), 0.0)
    turning = np.zeros((3, 5, len(h)))
    if first.moves is not None and second.moves is not None:
        turning = _turning(first.points[0].mid, first.moves.mid, second.points[0].mid, second.moves.mid)
    yield _Directions(exactly(mean), exactly(slope), exactly(turning))
    yield _Directions(exactly(mean), exactly(0.0 * slope), exactly(0.0 * turning))


def _turning(first: FloatArray, S: FloatArray, second: FloatArray, T: FloatArray) -> FloatArray:
    """Estimate how fast directions turn with each error, (3, 5, n), for points (k, 3, n) and their S (k, 3, 5, n)."""

    def moved(points: FloatArray, moves: FloatArray, by_m: float) -> FloatArray:
        return np.asarray(points[:, :, None] + by_m * moves, dtype=float).reshape(len(points), 3, -1)

    back, forth = (
        hull_separation(moved(first, S, by_m), moved(second, T, by_m)).normal.reshape(3, *S.shape[2:])
        for by_m in (-_PROBE_M, _PROBE_M)
    )
    rates = (forth - back) / (2.0 * _PROBE_M)
    return np.asarray(np.where(np.linalg.norm(rates, axis=0) < _FASTEST_PER_M, rates, 0.0), dtype=float)


def _closest(first: MovingHull, second: MovingHull, n: _Directions, h: FloatArray, errors_m: FloatArray) -> FloatArray:
    """Bound min n . (a - b) / |n| from below; -1 if that is not positive. Shape (n,)."""
    a, b = (_heights(hull.points, n) for hull in (first, second))
    gap = [one[:, None] - other[None] for one, other in zip(a, b, strict=True)]
    parts = [times(term.magnitude, power(h, k)) for k, term in enumerate(gap[1:], start=1)]
    size = np.maximum(*(norm((n.mean + n.slope * exactly(t)).magnitude) for t in (-h, h)))
    if first.moves is not None and second.moves is not None:
        parts.append(_closer((first.points, first.moves), (second.points, second.moves), n, h, errors_m))
        size = _longer(n, size, h, errors_m)
    least = (gap[0] - exactly(total(*parts))).lower.min(axis=(0, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((least > 0.0) & (size > 0.0), rounded_down(least / size, 1), -1.0)


def _heights(points: Sequence[Enclosure], n: _Directions) -> list[Enclosure]:
    """Compute the coefficients of n . a of order 0 to 3 in t, shape (k, n) each."""
    one, two = (Enclosure(part.mid[None], part.rad[None]) for part in (n.mean, n.slope))
    return [
        dot(one, points[0], 1),
        dot(one, points[1], 1) + dot(two, points[0], 1),
        dot(one, points[2], 1) + dot(two, points[1], 1),
        dot(two, points[2], 1),
    ]


def _closer(
    first: tuple[Sequence[Enclosure], Enclosure],
    second: tuple[Sequence[Enclosure], Enclosure],
    n: _Directions,
    h: FloatArray,
    errors_m: FloatArray,
) -> FloatArray:
    """Bound by how much n . (a - b) becomes smaller with the errors, (k, l, n)."""
    over, changes = n.mean + n.slope * within(h), []
    for points, moves in (first, second):
        everywhere = points[0] + points[1] * within(h) + points[2] * within(power(h, 2))
        changes.append(contract("cn,kcan->kan", over, moves, 3) + contract("can,kcn->kan", n.turning, everywhere, 3))
    linear = (_outer(changes[0]) - _inner(changes[1])).magnitude
    apart = norm(np.moveaxis((_outer(first[1]) - _inner(second[1])).magnitude, 2, 0))
    turned = bound("an,an->n", norm(n.turning.magnitude), errors_m, terms=5)
    by_turning = times(turned, bound("klan,an->kln", apart, errors_m, terms=5))
    return total(bound("klan,an->kln", linear, errors_m, terms=5), by_turning)


def _longer(n: _Directions, size: FloatArray, h: FloatArray, errors_m: FloatArray) -> FloatArray:
    """Bound |n| for all errors, where it is up to `size` (n,) without them."""
    along = contract("cn,can->an", n.mean + n.slope * within(h), n.turning, 3).magnitude
    turned = bound("an,an->n", norm(n.turning.magnitude), errors_m, terms=5)
    return root(total(times(size, size), 2.0 * bound("an,an->n", along, errors_m, terms=5), times(turned, turned)))


def _outer(values: Enclosure) -> Enclosure:
    return Enclosure(values.mid[:, None], values.rad[:, None])


def _inner(values: Enclosure) -> Enclosure:
    return Enclosure(values.mid[None], values.rad[None])


def _scaled(values: Enclosure, by: FloatArray) -> Enclosure:
    """Leave coordinates as they are, or out."""
    return Enclosure(values.mid * by, values.rad * by)
