"""How far apart the bodies of a machine are, surface to surface, for many poses at a time.

Boxes along the axes are compared first; only pairs whose boxes are near have their distance computed, of segments in
closed form (`clearance.segment_distance`), of other hulls by `shapes.gjk`. Overlapping hulls have no depth: the
distance of their surfaces is then less the sum of their radii.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.machine.bodies.placement import Frames
from pipeline.machine.clearance import segment_distance
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.gjk import hull_separation
from pipeline.machine.shapes.model import Bodies

_BLOCK = 2_048
"""Poses at a time: what belongs to them stays in fast memory."""
_FEW = 512
"""Poses at a time where all distances are computed: pairs are looked at all at a time then."""
_REACHES_M = (0.02, 0.1, 0.5, np.inf)
"""Distances within which the least one is looked for, one after the other."""
_RANKED = 128
"""Poses by which pairs are ranked, those that refuse most of them first."""
_DEAD = 0.25
"""Share of poses that are refused, beyond which they are no longer carried along."""


@dataclass(frozen=True, eq=False)
class _Placed:
    """All hulls at n poses: points (k, 3, n) each, and boxes along the axes around them, (hulls, 3, n)."""

    bodies: Bodies
    points: list[FloatArray]
    low: FloatArray
    high: FloatArray

    @classmethod
    def of(cls, bodies: Bodies, frames: Frames) -> Self:
        points = [frames.points(hull) for hull in bodies.hulls]
        low, high = np.empty((2, len(points), 3, len(frames)))
        for k, (hull, placed) in enumerate(zip(bodies.hulls, points, strict=True)):
            np.subtract(placed.min(axis=0), hull.radius_m, out=low[k])
            np.add(placed.max(axis=0), hull.radius_m, out=high[k])
            if hull.endless:
                low[k, 0], high[k, 0] = -np.inf, np.inf
        return cls(bodies, points, low, high)

    def take(self, rows: BoolArray) -> Self:
        points = [placed[..., rows] for placed in self.points]
        return type(self)(self.bodies, points, self.low[..., rows], self.high[..., rows])

    def near(self, pair: tuple[int, int], reach_m: float) -> BoolArray:
        """Tell at which poses the boxes of a pair are no farther apart than `reach_m` along any axis. Shape (n,)."""
        i, j = pair
        near = np.ones(self.low.shape[2], dtype=bool)
        for axis in range(3):
            near &= self.low[i, axis] - self.high[j, axis] <= reach_m
            near &= self.low[j, axis] - self.high[i, axis] <= reach_m
        return near

    def all_near(self, reach_m: float) -> BoolArray:
        """Tell of all pairs at a time what `near` does of one. Shape (pairs, n)."""
        first, second = np.array(self.bodies.pairs, dtype=np.int64).reshape(-1, 2).T
        gap = np.maximum(self.low[first] - self.high[second], self.low[second] - self.high[first])
        return np.asarray((gap <= reach_m).all(axis=1))

    def distances_of(self, pair: IntArray, row: IntArray, beyond_m: float) -> FloatArray:
        """Compute the distances of m pairs, each at a pose of its own, as `distances` does. Shape (m,)."""
        found = np.empty(len(pair))
        ends = np.array(self.bodies.pairs, dtype=np.int64).reshape(-1, 2)[pair]
        sizes = np.array([len(points) for points in self.points])
        endless: BoolArray = np.array([self.bodies.is_endless(one) for one in self.bodies.pairs], dtype=bool)[pair]
        radii = np.array([hull.radius_m for hull in self.bodies.hulls])[ends].sum(axis=1)
        short = (sizes[ends] <= 2).all(axis=1)
        for rows, corners in ((np.flatnonzero(short), 2), (np.flatnonzero(~short), int(sizes.max(initial=2)))):
            if len(rows) == 0:
                continue
            padded = _padded(self.points, ends[rows], corners)
            first, second = (padded[where, :, :, row[rows]] for where in ends[rows].T)
            first[endless[rows], :, 0] = second[endless[rows], :, 0] = 0.0
            if corners == 2:
                p, u, q, v = (
                    np.asfortranarray(part)
                    for part in (first[:, 0], first[:, 1] - first[:, 0], second[:, 0], second[:, 1] - second[:, 0])
                )
                found[rows] = segment_distance(p, u, q, v)
            else:
                # What is beyond the farthest that counts for any pair need not be known better.
                most = beyond_m + float(radii[rows].max())
                found[rows] = hull_separation(_pairs_last(first), _pairs_last(second), most).distance_m
        return np.asarray(found - radii, dtype=float)

    def distances(self, pair: tuple[int, int], rows: IntArray, beyond_m: float) -> FloatArray:
        """Compute the distances of a pair at some poses; beyond `beyond_m` lower bounds will do. Shape (rows,)."""
        first, second = (self.points[k][..., rows] for k in pair)
        if self.bodies.is_endless(pair):
            first[:, 0] = second[:, 0] = 0.0
        radii = self.bodies.radii_m(pair)
        if len(first) <= 2 and len(second) <= 2:
            (p, u), (q, v) = ((points[0].T, (points[-1] - points[0]).T) for points in (first, second))
            return np.asarray(segment_distance(p, u, q, v) - radii, dtype=float)
        return hull_separation(first, second, beyond_m + radii).distance_m - radii


def _pairs_last(points: FloatArray) -> FloatArray:
    return np.ascontiguousarray(np.moveaxis(points, 0, -1))


def _padded(points: list[FloatArray], ends: IntArray, corners: int) -> FloatArray:
    """Give hulls the same number of corners, their last one repeated; only those that are used. (hulls, k, 3, n)."""
    stacked = np.zeros((len(points), corners, *points[0].shape[1:]))
    for number in np.unique(ends).tolist():
        placed = points[number]
        stacked[number, : len(placed)], stacked[number, len(placed) :] = placed, placed[-1]
    return stacked


def body_distances(bodies: Bodies, samples: PoseSamples, reach_m: float = np.inf) -> FloatArray:
    """Compute the distances of all pairs at n poses, shape (n, pairs); what is beyond `reach_m` has that value."""
    found = np.full((len(samples), len(bodies.pairs)), reach_m)
    for begin in range(0, len(samples), _FEW):
        part = slice(begin, begin + _FEW)
        placed = _Placed.of(bodies, Frames.of(samples.machine, samples.pose[part], samples.carts_m[part]))
        pair, row = np.nonzero(placed.all_near(reach_m))
        found[begin + row, pair] = np.minimum(placed.distances_of(pair, row, reach_m), reach_m)
    return found


def least_distances(bodies: Bodies, samples: PoseSamples) -> FloatArray:
    """Compute the least distance of all pairs at each of n poses, shape (n,): no pair is pursued that is not near."""
    least, rows = np.empty(len(samples)), np.arange(len(samples))
    for reach in _REACHES_M:
        least[rows] = body_distances(bodies, samples.take(rows), reach).min(axis=1)
        rows = rows[least[rows] >= reach]
    return least


def least_distance(bodies: Bodies, samples: PoseSamples) -> float:
    """Compute the least distance of all pairs at any of n poses."""
    for reach in _REACHES_M:
        least = float(body_distances(bodies, samples, reach).min())
        if least < reach:
            break
    return least


def are_clear(bodies: Bodies, samples: PoseSamples) -> BoolArray:
    """Tell at which of n poses all pairs keep their clearance. Shape (n,).

    Pairs are tried in the order in which they refuse most of a few poses; poses that are refused are left out then.
    """
    frames = Frames.of(samples.machine, samples.pose, samples.carts_m)
    clear = np.ones(len(samples), dtype=bool)
    order = _deadliest_first(bodies, frames)
    for begin in range(0, len(samples), _BLOCK):
        part = np.arange(begin, min(begin + _BLOCK, len(samples)))
        clear[part] = _all_clear(_Placed.of(bodies, frames.take(part)), order)
    return clear


def _deadliest_first(bodies: Bodies, frames: Frames) -> list[int]:
    """Rank the pairs by how many of a few poses each of them refuses."""
    rows = np.unique(np.linspace(0, max(len(frames) - 1, 0), min(_RANKED, len(frames))).astype(np.int64))
    placed, least = _Placed.of(bodies, frames.take(rows)), bodies.clearance_m
    refused = []
    for pair in bodies.pairs:
        near = np.flatnonzero(placed.near(pair, least))
        refused.append(np.count_nonzero(placed.distances(pair, near, least) < least) if len(near) else 0)
    order: list[int] = np.argsort(-np.array(refused, dtype=np.int64), kind="stable").tolist()
    return order


def _all_clear(placed: _Placed, order: list[int]) -> BoolArray:
    """Tell at which poses of a block all pairs keep their clearance."""
    least = placed.bodies.clearance_m
    clear = np.ones(placed.low.shape[2], dtype=bool)
    carried, alive = np.arange(len(clear)), clear.copy()
    for k in order:
        pair = placed.bodies.pairs[k]
        near = np.flatnonzero(placed.near(pair, least) & alive)
        if len(near) == 0:
            continue
        alive[near] = placed.distances(pair, near, least) >= least
        if np.count_nonzero(alive) < (1.0 - _DEAD) * len(alive):
            clear[carried[~alive]] = False
            carried, placed = carried[alive], placed.take(alive)
            alive = np.ones(len(carried), dtype=bool)
            if len(carried) == 0:
                break
    clear[carried[~alive]] = False
    return clear
