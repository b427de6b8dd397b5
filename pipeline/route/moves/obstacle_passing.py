"""Obstacles beside moves: on which side along X each body passes them, and whether it does so all along a move.

A region's window of x is on one side of what a pair of a body and an obstacle excludes, or the pair excludes nothing
there: then their projections along X are far enough apart. As distances are convex in x, a move is clear for every x of
both windows if it is clear for those nearest to the obstacle, both on one side of it; where neither region has a side,
if the projections stay apart.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import Config
from pipeline.limits.bodies.obstacle_distance import obstacles_of
from pipeline.limits.bodies.surface_distance import REACH_M
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.geometry import Machine
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.model import Bodies
from pipeline.parallel import blocks, in_parallel
from pipeline.route.metric import step_sizes
from pipeline.route.moves.bisection import bisect, sample_lines
from pipeline.route.regions.obstacles import excluded_x
from pipeline.route.regions.table import RegionTable

_BLOCK = 2_048
"""Batch size, in regions and in moves."""
_ROUNDING_M = 1e-9
_TOUCHING_M = 1e-9
"""Windows end where bodies are this much too close at most."""


def obstacle_codes(config: Config, machine: Machine, regions: RegionTable, bits: int) -> IntArray:
    """Sides of all pairs, which no move has opposite, as bits of words (`candidates.passing_codes`). (words, n)."""
    pairs = obstacles_of(config)
    if pairs is None:
        return np.empty((0, len(regions)), dtype=np.int64)
    tasks = [partial(_codes, pairs, machine, regions.take(part), bits) for part in blocks(len(regions), _BLOCK)]
    words = -(-len(pairs.pairs) // bits)
    return np.concatenate([np.empty((words, 0), dtype=np.int64), *in_parallel(tasks)], axis=1)


def _codes(pairs: Bodies, machine: Machine, regions: RegionTable, bits: int) -> IntArray:
    sides = _sides(pairs, machine, regions)
    codes = np.zeros((-(-sides.shape[1] // bits), len(regions)), dtype=np.int64)
    for number, side in enumerate(sides.T):
        word, bit = divmod(number, bits)
        codes[word] |= (side > 0).astype(np.int64) << bit
        codes[word] |= (side < 0).astype(np.int64) << (bit + bits)
    return codes


def _sides(pairs: Bodies, machine: Machine, regions: RegionTable) -> IntArray:
    """Tell on which side of each pair's interval the windows are: 1 below, -1 above, 0 without one. (n, pairs)."""
    excluded, windows = excluded_x(pairs, machine, regions), regions.x_window_m
    below = windows[:, 1:] <= excluded[..., 0] + _ROUNDING_M
    above = windows[:, :1] >= excluded[..., 1] - _ROUNDING_M
    return below.astype(np.int64) - (above & ~below).astype(np.int64)


def obstacles_hit(config: Config, machine: Machine, regions: RegionTable, ends: IntArray) -> BoolArray:
    """Find which moves between rows (m, 2) bring a body too close to an obstacle for some x of their windows. (m,)."""
    pairs = obstacles_of(config)
    if pairs is None:
        return np.zeros(len(ends), dtype=bool)
    follower = _Follower(pairs, machine, regions, float(step_sizes(config.route)[0]), config.route.follow.max_samples)
    found = [follower.hit(ends[part.start : part.stop]) for part in blocks(len(ends), _BLOCK)]
    return np.concatenate([np.empty(0, dtype=bool), *found])


@dataclass(frozen=True, eq=False)
class _Follower:
    """Follows moves past obstacles."""

    pairs: Bodies
    machine: Machine
    regions: RegionTable
    x_step_m: float
    max_samples: int

    def hit(self, ends: IntArray) -> BoolArray:
        """Find which moves (m, 2) come too close."""
        rows, numbers = np.unique(ends, return_inverse=True)
        sides = _sides(self.pairs, self.machine, self.regions.take(rows))[numbers.reshape(-1, 2)]
        hit = np.asarray((sides[:, 0] * sides[:, 1] < 0).any(axis=1))
        side = np.where(sides[:, 0] != 0, sides[:, 0], sides[:, 1])
        low, high = np.moveaxis(self.regions.x_window_m[ends], -1, 0)
        nearest_below = np.minimum(high, high[:, ::-1] + self.x_step_m)
        nearest_above = np.maximum(low, low[:, ::-1] - self.x_step_m)
        for pairs, applies, x in (
            (self.pairs, side > 0, nearest_below),
            (self.pairs, side < 0, nearest_above),
            (_projected(self.pairs), side == 0, nearest_below),
        ):
            moves = np.flatnonzero(applies.any(axis=1) & ~hit)
            if len(moves):
                hit[moves] = self._broken(pairs, applies[moves], ends[moves], x[moves])
        return hit

    def _broken(self, pairs: Bodies, applies: BoolArray, ends: IntArray, x: FloatArray) -> BoolArray:
        """Follow moves (m, 2) at x (m, 2) of their ends; what may change its branch counts as broken."""
        counting = np.flatnonzero(applies.any(axis=0))
        pairs, applies = pairs.only(counting), applies[:, counting]
        pose, q = self.regions.pose[ends], self.regions.q_m[ends]
        q[..., :3] += (x - pose[..., 0])[..., None]
        pose[..., 0] = x

        def margins(samples: PoseSamples) -> FloatArray:
            distances = body_distances(pairs, samples, pairs.clearance_m + REACH_M)
            return np.asarray(distances - pairs.clearance_m + _TOUCHING_M, dtype=float)

        samples = PoseSamples(self.machine, pose.reshape(-1, 6), q.reshape(-1, 5))
        known = sample_lines(samples, margins).at(np.arange(len(samples)).reshape(-1, 2))
        found = bisect(self.machine, margins, applies, q, known, self.max_samples)
        return np.asarray(found.doubtful | found.broken.any(axis=1))


def _projected(pairs: Bodies) -> Bodies:
    """Give pairs whose distances are those of their projections along X."""
    fixed = {j for _, j in pairs.pairs}
    hulls = tuple(replace(hull, endless=True) if k in fixed else hull for k, hull in enumerate(pairs.hulls))
    return replace(pairs, hulls=hulls)
