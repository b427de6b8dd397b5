"""Rigorous lower bounds of the distances between the surfaces of bodies over a whole box, by separating directions.

For any n(t), two hulls of points a, b with radii r, r' are at least min n . (a - b) / |n| - r - r' apart. The direction
is linear in t, from the shortest connections at both ends of the box; where that shows too little, a constant one is
tried. Any direction gives a valid bound.

Coefficients of the points are balls; all pairs are then bounded at a time, in floats. What floats lose is bounded
beforehand: no entry takes more than 60 operations, each of which loses at most 2^-53 of a magnitude that is computed.

Where a link is cut short, or a tube ends, by metres along its axis, its length over the box decides where that is at
most: the hull is taken between these points.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_series

from pipeline.arrays import FloatArray
from pipeline.inclusion.bounds import actuator_ranges
from pipeline.inclusion.closure import Closure
from pipeline.inclusion.condition import above, norm
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES
from pipeline.machine.shapes.gjk import hull_separation
from pipeline.machine.shapes.model import Bodies, FrameKind, SweptHull

_LOST = 1e-13
"""Part of the largest magnitude that floats lose at most in a bound: ten times 60 roundings."""
_ORDERS = 3


@dataclass(frozen=True, eq=False)
class _Frames:
    """The frames that hulls move with, as balls: middles and radii of their coefficients of order 0, 1 and 2 in t.

    Attributes
    ----------
    tcp, rotation : (2, orders, 3), (2, orders, 3, 3)
        TCP and R.
    origins : (2, orders, 3, 3)
        The points of the rails that the carts are at.
    carts, platform : (2, orders, 6, 3)
        Cart joints and platform joints.
    arms : (6,)
        Bounds of how far the platform joints are from the TCP.
    shift, turn : float
        Bounds of how far the pose is off the series: its place, and the sum of its angles.
    lengths : (6, 2)
        Least and largest length of each link.
    """

    tcp: FloatArray
    rotation: FloatArray
    origins: FloatArray
    carts: FloatArray
    platform: FloatArray
    arms: FloatArray
    shift: float
    turn: float
    lengths: FloatArray


@dataclass(frozen=True, eq=False)
class _Moving:
    """The points of hulls over a box.

    Attributes
    ----------
    middle, radius : (orders, pairs, k, 3)
        Coefficients.
    off : (pairs,)
        How far a point is off them at most.
    """

    middle: FloatArray
    radius: FloatArray
    off: FloatArray

    def at(self, t: float) -> FloatArray:
        """Evaluate the middles, shape (k, 3, pairs)."""
        value = self.middle[0] + t * self.middle[1] + t * t * self.middle[2]
        return np.ascontiguousarray(np.moveaxis(value, 0, -1))


def body_distance_bounds(box: ProvenBox, bodies: Bodies) -> FloatArray:
    """Bound the distances of all pairs from below over a proven box, negative if nothing is known. Shape (pairs,)."""
    frames, half = _frames(box), above(box.series.half)
    placed = [_points(frames, hull) for hull in bodies.hulls]
    bounds = np.full(len(bodies.pairs), -np.inf)
    for pairs in _by_size(bodies).values():
        first, second = (_gather(bodies, placed, pairs, side) for side in (0, 1))
        radii = np.array([bodies.radii_m(bodies.pairs[k]) for k in pairs])
        found = _separated(first, second, half)
        bounds[pairs] = np.nextafter(found - (first.off + second.off) - radii - _LOST, -np.inf)
    return bounds


def _by_size(bodies: Bodies) -> dict[tuple[int, int], list[int]]:
    """Group pairs by the numbers of points of both hulls."""
    groups: dict[tuple[int, int], list[int]] = {}
    for k, (i, j) in enumerate(bodies.pairs):
        groups.setdefault((len(bodies.hulls[i].points_m), len(bodies.hulls[j].points_m)), []).append(k)
    return groups


def _gather(bodies: Bodies, placed: list[tuple[FloatArray, FloatArray, float]], pairs: list[int], side: int) -> _Moving:
    """Put the hulls on one side of pairs together; of pairs with one that is endless along X, x is left out."""
    chosen = [placed[bodies.pairs[k][side]] for k in pairs]
    middle, radius = (np.stack([part[which] for part in chosen], axis=1) for which in (0, 1))
    endless = np.array([bodies.is_endless(bodies.pairs[k]) for k in pairs])
    middle[:, endless, :, 0] = radius[:, endless, :, 0] = 0.0
    return _Moving(middle, radius, np.array([part[2] for part in chosen]))


def _separated(first: _Moving, second: _Moving, half: float) -> FloatArray:
    """Bound the distances of pairs of hulls from below by two choices of directions. Shape (pairs,)."""
    before, after = (hull_separation(first.at(t), second.at(t)).normal.T for t in (-half, half))
    mean = (before + after) / 2.0
    slope = (after - before) / (2.0 * half) if half > 0.0 else np.zeros_like(mean)
    turning = _bound(first, second, (mean, slope), half)
    still = _bound(first, second, (mean, np.zeros_like(mean)), half)
    return np.maximum(turning, still)


def _bound(first: _Moving, second: _Moving, n: tuple[FloatArray, FloatArray], half: float) -> FloatArray:
    """Bound min n . (a - b) / |n| over |t| <= half for directions n0 + n1 t, (pairs, 3) each. Shape (pairs,)."""
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
    length = np.maximum(*(np.linalg.norm(n[0] + t * n[1], axis=1) for t in (-half, half)))
    most = 3.0 * (reach[0] + reach[1]) * (np.abs(n[0]) + half * np.abs(n[1])).max(axis=1)
    least = least.min(axis=(1, 2)) - _LOST * (1.0 + most + size.max(axis=(1, 2)))
    return np.where((length > 0.0) & (least > 0.0), least / np.maximum(length * (1.0 + _LOST), 1e-300), -1.0)


def _heights(moving: _Moving, n: tuple[FloatArray, FloatArray]) -> tuple[list[FloatArray], list[FloatArray]]:
    """Compute the coefficients of n . a of order 0 to 3 in t, middles and radii (pairs, k) each."""
    p, r = moving.middle, moving.radius

    def dot(normal: FloatArray, points: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("pc,pkc->pk", normal, points), dtype=float)

    middles = [
        dot(n[0], p[0]),
        dot(n[0], p[1]) + dot(n[1], p[0]),
        dot(n[0], p[2]) + dot(n[1], p[1]),
        dot(n[1], p[2]),
    ]
    sizes = [np.abs(part) for part in n]
    radii = [
        dot(sizes[0], r[0]),
        dot(sizes[0], r[1]) + dot(sizes[1], r[0]),
        dot(sizes[0], r[2]) + dot(sizes[1], r[1]),
        dot(sizes[1], r[2]),
    ]
    return middles, radii


def _points(frames: _Frames, hull: SweptHull) -> tuple[FloatArray, FloatArray, float]:
    """Give the coefficients of a hull's points, middles and radii (orders, k, 3), and how far points may be off."""
    given = hull.points_m
    if hull.kind == FrameKind.PLATFORM:
        middle = frames.tcp[0][:, None] + np.einsum("oij,kj->oki", frames.rotation[0], given)
        radius = frames.tcp[1][:, None] + np.einsum("oij,kj->oki", frames.rotation[1], np.abs(given))
        far = float(np.linalg.norm(given, axis=1).max())
        return middle, radius, frames.shift + far * frames.turn
    if hull.kind == FrameKind.LINK:
        part = _parts(hull, frames.lengths[hull.number])[None, :, None]
        ends = [(1.0 - part, frames.carts), (part, frames.platform)]
        middle = sum((share * joint[0][:, hull.number, None] for share, joint in ends), np.zeros(1))
        radius = sum((np.abs(share) * joint[1][:, hull.number, None] for share, joint in ends), np.zeros(1))
        return middle, radius, float(part.max()) * (frames.shift + float(frames.arms[hull.number]) * frames.turn)
    middle, radius = np.zeros((2, _ORDERS, *given.shape))
    if hull.kind == FrameKind.CART:
        middle += frames.origins[0][:, hull.number, None]
        radius += frames.origins[1][:, hull.number, None]
    middle[0] += given
    return middle, radius, 0.0


def _parts(hull: SweptHull, lengths: FloatArray) -> FloatArray:
    """Give both ends of a hull on a link as parts of its length, as far apart as any length in a range makes them."""
    parts = hull.points_m[:, 0] + hull.points_m[:, 1] / lengths[:, None]
    return np.array([parts[:, 0].min(), parts[:, 1].max()])


def _frames(box: ProvenBox) -> _Frames:
    closures, ranges = (box.series.at, box.series.at, box.series.over), actuator_ranges(box)
    lengths = np.repeat(np.asarray(box.machine.lengths_m)[:, None], 2, axis=1)
    lengths[TELESCOPES] = ranges[3:]
    deviation = box.inclusion.image
    return _Frames(
        tcp=_balls([[x[k] for x in one.pose[:3]] for k, one in enumerate(closures)]),
        rotation=_balls([[[x[k] for x in row] for row in one.rotation] for k, one in enumerate(closures)]),
        origins=_balls([_origins(box, one, k) for k, one in enumerate(closures)]),
        carts=_balls([_cart_joints(box, one, k) for k, one in enumerate(closures)]),
        platform=_balls([_platform_joints(one, k) for k, one in enumerate(closures)]),
        arms=np.array([above(norm(point)) for point in box.balls.points]),
        shift=above(norm(deviation[:3])),
        turn=above(sum((d.abs_upper() for d in deviation[3:]), arb(0))),
        lengths=lengths,
    )


def _origins(box: ProvenBox, closure: Closure[arb_series], order: int) -> list[list[arb]]:
    constant = arb(int(order == 0))
    return [
        [closure.q[arm][order], arb(y) * constant, arb(z) * constant]
        for arm, (y, z) in enumerate(box.machine.rails_m.tolist())
    ]


def _cart_joints(box: ProvenBox, closure: Closure[arb_series], order: int) -> list[list[arb]]:
    constant = arb(int(order == 0))
    return [
        [closure.q[ARM_OF_LINK[link]][order] + x * constant, y * constant, z * constant]
        for link, (x, y, z) in enumerate(box.balls.anchors)
    ]


def _platform_joints(closure: Closure[arb_series], order: int) -> list[list[arb]]:
    return [[p[order] + a[order] for p, a in zip(closure.pose, arm, strict=False)] for arm in closure.arms]


def _balls(table: object) -> FloatArray:
    """Turn nested lists of balls into middles and radii, stacked; radii include what the middles are rounded by."""
    entries = np.array(table, dtype=object)
    middle = np.array([float(entry.mid()) for entry in entries.ravel()])
    radius = np.array(
        [above((entry - arb(value)).abs_upper()) for entry, value in zip(entries.ravel(), middle.tolist(), strict=True)]
    )
    return np.stack([middle.reshape(entries.shape), radius.reshape(entries.shape)])
