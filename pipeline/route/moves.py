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
_OFFSETS = np.stack(np.meshgrid(*[[-1, 0, 1]] * 4, indexing="ij"), axis=-1).reshape(-1, 4)
"""The cell itself and its neighbours in y, z, rx, rz; of a direction and its reverse one is above zero."""


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
    return _collect(_Search.of(regions, steps, passing_codes(machine, regions), steps[0]), regions, progress)


def rule_moves(config: Config, regions: RegionTable) -> Moves:
    """Find all moves that (14)-(17) and (38) alone would admit, whatever x, det H and the links do."""
    steps = step_sizes(config.route)
    return _collect(_Search.of(regions, steps, np.zeros(len(regions), dtype=np.int64), np.inf), regions, silent)


def _collect(search: "_Search", regions: RegionTable, progress: Progress) -> Moves:
    """Look at all neighbouring cells.

    Between regions of the same working mode a move can be made both ways, so that half of the directions is
    looked at; moves that change a mode at a gate are looked at one by one.
    """
    kept, changing = np.arange(len(regions), dtype=np.int32), np.flatnonzero(regions.gate).astype(np.int32)
    arrival = regions.mode[changing] ^ gate_bit(regions.gate[changing])
    found: list[tuple[IntArray, IntArray]] = []
    for count, offset in enumerate(_OFFSETS):
        progress("moves", count / len(_OFFSETS))
        if tuple(offset) >= (0, 0, 0, 0):
            i, j = search.pairs(kept, regions.mode, offset)
            if not offset.any():
                i, j = i[i < j], j[i < j]
            found += [(i, j), (j, i)]
        found.append(search.pairs(changing, arrival, offset))
    source, target = (np.concatenate(side) for side in zip(*found, strict=True))
    allowed = (source != regions.goal) & (target != regions.start)
    source, target = source[allowed], target[allowed]
    order = np.argsort(source, kind="stable")
    return Moves(source[order], target[order])


@dataclass(frozen=True, eq=False)
class _Search:
    """What decides whether two regions of neighbouring cells can be joined."""

    buckets: "_Buckets"
    cells: IntArray
    coordinates: FloatArray
    codes: IntArray
    opposite: IntArray
    low_m: FloatArray
    high_m: FloatArray
    x_step_m: float

    @classmethod
    def of(cls, regions: RegionTable, steps: FloatArray, codes: IntArray, x_step_m: float) -> "_Search":
        """Sort the regions; `codes` (n,) as of `passing_codes`, `x_step_m` the largest move along X."""
        coordinates = regions.controlled[:, 1:] / steps[1:]
        opposite = (codes >> _SHIFT) | ((codes & _LOW) << _SHIFT)
        buckets, cells = _Buckets.of(coordinates, regions.mode)
        low, high = regions.x_window_m.T.copy()
        return cls(buckets, cells, coordinates.T.copy(), codes, opposite, low, high, x_step_m + _ROUNDING)

    def pairs(self, origins: IntArray, modes: IntArray, offset: IntArray) -> tuple[IntArray, IntArray]:
        """Regions (n,) with all they can be joined to in the cell `offset` away, arriving in working modes (n,)."""
        i, j = self.buckets.pairs(origins, self.cells[origins] + offset, modes)
        # Opposite signs of det H, or of a passing pair of links, share a bit.
        clear = (self.codes[i] & self.opposite[j]) == 0
        i, j = i[clear], j[clear]
        # Within one cell no coordinate differs by a whole step.
        for axis in np.flatnonzero(offset):
            near = np.abs(self.coordinates[axis, i] - self.coordinates[axis, j]) <= 1.0 + _ROUNDING
            if not near.all():
                i, j = i[near], j[near]
        apart = np.maximum(self.low_m[i] - self.high_m[j], self.low_m[j] - self.high_m[i])
        within = apart <= self.x_step_m
        return i[within], j[within]


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
        return cls(np.argsort(key, kind="stable").astype(np.int32), begin, shape, low), cells

    def pairs(self, origins: IntArray, cells: IntArray, modes: IntArray) -> tuple[IntArray, IntArray]:
        """Every origin (n,) with every region of its cell (n, 4) and mode (n,), as two arrays of rows."""
        key = np.ravel_multi_index((modes, *(cells - self.low).T), self.shape)
        begin, count = self.begin[key], self.begin[key + 1] - self.begin[key]
        rows = np.repeat(np.arange(len(origins), dtype=np.int32), count)
        shift = begin - (np.cumsum(count) - count)
        return origins[rows], self.order[np.arange(len(rows)) + shift[rows]]
