"""Moves between regions: which of them a step may join.

A move needs every coordinate within one grid step (14)-(17), the working mode of every arm kept unless the
arm is at its gate (38), windows of x within reach of each other (13), the same sign of det H, and no links
passing through each other. The last two are cheap filters; `follow` is what a route is finally held against.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from pipeline.config import Config
from pipeline.machine.clearance import common_perpendicular, link_pairs
from pipeline.machine.geometry import FloatArray, IntArray, Machine, cart_joints, link_vectors
from pipeline.progress import Progress, silent
from pipeline.route.grid import gate_bit
from pipeline.route.metric import step_sizes
from pipeline.route.regions import RegionTable

_SLACK = 0.05
"""How far beyond a link's ends the closest points still count as inside it, in lengths of the link."""
_ROUNDING = 1e-9
_LOW = 0xFFFF
_SHIFT = 16


@dataclass(frozen=True, eq=False)
class Moves:
    """Directed moves, sorted by their source.

    Attributes
    ----------
    source, target : (m,)
        Rows of the region table.
    """

    source: IntArray
    target: IntArray

    def __len__(self) -> int:
        return len(self.source)

    def graph(self, cost: FloatArray) -> csr_array:
        """The moves as a sparse matrix whose entries are the cost (regions,) of their source."""
        n = len(cost)
        pointer = np.concatenate([[0], np.cumsum(np.bincount(self.source, minlength=n))])
        return csr_array((cost[self.source], self.target, pointer), shape=(n, n))


def find_moves(config: Config, machine: Machine, regions: RegionTable, progress: Progress = silent) -> Moves:
    """Find all admitted moves, from the start and between regions up to the goal, which is never left."""
    steps = step_sizes(config.route)
    coordinates = regions.controlled[:, 1:] / steps[1:]
    codes = passing_codes(machine, regions)
    opposite = (codes >> _SHIFT) | ((codes & _LOW) << _SHIFT)
    bucket, cells = _Buckets.of(coordinates, regions.mode)
    flip = gate_bit(regions.gate)
    rows = np.arange(len(regions))
    leaving = rows[rows != regions.goal]
    at_gate = leaving[flip[leaving] > 0]
    origins = np.concatenate([leaving, at_gate])
    arrival_modes = np.concatenate([regions.mode[leaving], regions.mode[at_gate] ^ flip[at_gate]])
    sources, targets = [], []
    offsets = np.stack(np.meshgrid(*[[-1, 0, 1]] * 4, indexing="ij"), axis=-1).reshape(-1, 4)
    for count, offset in enumerate(offsets):
        progress("moves", count / len(offsets))
        i, j = bucket.pairs(origins, cells[origins] + offset, arrival_modes)
        near = (np.abs(coordinates[i] - coordinates[j]) <= 1.0 + _ROUNDING).all(axis=1)
        i, j = i[near], j[near]
        # Opposite signs of det H, or of a passing pair of links, share a bit.
        clear = ((codes[i] & opposite[j]) == 0) & (i != j) & (j != regions.start)
        i, j = i[clear], j[clear]
        apart = np.maximum(
            regions.x_window_m[i, 0] - regions.x_window_m[j, 1],
            regions.x_window_m[j, 0] - regions.x_window_m[i, 1],
        )
        within = apart <= steps[0] + _ROUNDING
        sources.append(i[within].astype(np.int32))
        targets.append(j[within].astype(np.int32))
    source, target = np.concatenate(sources), np.concatenate(targets)
    order = np.argsort(source, kind="stable")
    return Moves(source[order], target[order])


def passing_codes(machine: Machine, regions: RegionTable) -> IntArray:
    """Signs that two neighbouring regions must not have opposite, as bits. Shape (n,).

    Bits 0 to 15 stand for positive, bits 16 to 31 for negative: of the signed distance along the common
    perpendicular of each pair of links whose closest points lie inside both (neither bit otherwise), and last
    of det H.
    """
    carts = regions.q_m[:, :3]
    pose = regions.pose
    start, vector = cart_joints(machine, carts), link_vectors(machine, pose, carts)
    signs = []
    for a, b in link_pairs(machine):
        signed, s, t = common_perpendicular(start[:, a], vector[:, a], start[:, b], vector[:, b])
        with np.errstate(invalid="ignore"):
            inside = (np.abs(s - 0.5) <= 0.5 + _SLACK) & (np.abs(t - 0.5) <= 0.5 + _SLACK)
        signs.append(np.where(inside, np.sign(signed), 0.0))
    signs.append(regions.det_sign)
    codes = np.zeros(len(regions), dtype=np.int64)
    for bit, sign in enumerate(signs):
        codes |= (sign > 0).astype(np.int64) << bit
        codes |= (sign < 0).astype(np.int64) << (bit + _SHIFT)
    return codes


@dataclass(frozen=True, eq=False)
class _Buckets:
    """Regions sorted by working mode and grid cell, to look up all of a cell at once."""

    order: IntArray
    begin: IntArray
    shape: tuple[int, ...]
    low: IntArray

    @classmethod
    def of(cls, coordinates: FloatArray, modes: IntArray) -> tuple["_Buckets", IntArray]:
        """Sort regions into cells of coordinates (n, 4) counted in steps; also give their cells (n, 4)."""
        cells = np.floor(coordinates - coordinates.min(axis=0) + _ROUNDING).astype(np.int64)
        # An empty rim on every side spares the neighbours' bounds checks.
        low, shape = np.full(4, -1), (8, *(cells.max(axis=0) + 3))
        key = np.ravel_multi_index((modes, *(cells - low).T), shape)
        begin = np.concatenate([[0], np.cumsum(np.bincount(key, minlength=int(np.prod(shape))))])
        return cls(np.argsort(key, kind="stable"), begin, shape, low), cells

    def pairs(self, origins: IntArray, cells: IntArray, modes: IntArray) -> tuple[IntArray, IntArray]:
        """Every origin with every region of its cell (n, 4) and mode (n,), as two arrays of rows."""
        key = np.ravel_multi_index((modes, *(cells - self.low).T), self.shape)
        begin, count = self.begin[key], self.begin[key + 1] - self.begin[key]
        rows = np.repeat(np.arange(len(origins)), count)
        within = np.arange(len(rows)) - np.repeat(np.cumsum(count) - count, count)
        return origins[rows], self.order[begin[rows] + within]
