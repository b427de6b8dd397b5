"""Moves between regions: which of them a step may join.

A move needs every coordinate within one grid step (14)-(17), the working mode of every arm kept unless the
arm is at its gate (38) and leaves it, windows of x within reach of each other (13), the same sign of det H, and no
links passing through each other. The last two are cheap filters; `check` decides about the moves that a route may use.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.sparse import csr_array

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import Config
from pipeline.machine.clearance import common_perpendicular, link_pairs
from pipeline.machine.geometry import Machine, cart_joints, link_vectors
from pipeline.parallel import blocks, in_parallel
from pipeline.progress import QUIET, Monitor, Progress, silent
from pipeline.route.memory import memory_gb, require_memory
from pipeline.route.metric import step_sizes
from pipeline.route.moves.body_passing import body_codes
from pipeline.route.moves.neighbours import Cells
from pipeline.route.moves.obstacle_passing import obstacle_codes
from pipeline.route.regions.boxes import crossings, grown_boxes
from pipeline.route.regions.gates import gate_bit
from pipeline.route.regions.table import RegionTable

_SLACK = 0.05
"""How far beyond a link's ends the closest points still count as inside it, in lengths of the link."""
_ROUNDING = 1e-9
_LOW = 0xFFFF
_SHIFT = 16
_BLOCK = 2_048
"""Batch size of the neighbour search, in regions."""
_CANDIDATES = 1_000_000
"""Candidates of a batch at most, in about 60 bytes each."""
_CODES_BLOCK = 8_192
"""Batch size of the passing codes, in regions."""
_SAMPLE = 4_096
"""Origins the number of moves is estimated from."""


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

    def take(self, rows: IntArray | BoolArray) -> "Moves":
        """Keep only these, in their order."""
        return Moves(self.source[rows], self.target[rows])

    def graph(self, cost: FloatArray, regions: int) -> csr_array:
        """The moves as a sparse matrix (regions, regions) whose entries are their costs (m,)."""
        n = regions
        # Indices and pointers of different types would both be copied.
        index_type = np.int32 if len(self) < 2**31 else np.int64
        pointer = np.searchsorted(self.source, np.arange(n + 1)).astype(index_type)
        target = np.ascontiguousarray(self.target, dtype=index_type)
        return csr_array((cost, target, pointer), shape=(n, n))


def find_moves(config: Config, machine: Machine, regions: RegionTable, monitor: Monitor = QUIET) -> Moves:
    """Find all admitted moves, from the start and between regions up to the goal, which is never left.

    Raises
    ------
    NoSolutionError
        When moves and shortest paths would take up more than `route.memory_gb`.
    """
    steps = step_sizes(config.route)
    codes = np.vstack(
        [
            passing_codes(machine, regions),
            body_codes(machine, regions, _SHIFT),
            obstacle_codes(config, machine, regions, _SHIFT),
        ]
    )
    search = MoveSearch.of(regions, steps, codes, steps[0])
    expected = search.expected_moves()
    require_memory(
        config.route,
        1e9 * memory_gb(len(regions), expected),
        f"about {expected:,} moves between {len(regions):,} regions",
        "coarsen route.grid: twice the tilt steps make a quarter of the regions",
        regions=len(regions),
        expected_moves=expected,
    )
    moves = search.collect(monitor.progress)
    crossing = crossings(grown_boxes(config), regions, steps, moves.source, moves.target)
    return moves.take(~crossing) if crossing.any() else moves


def rule_moves(config: Config, regions: RegionTable) -> Moves:
    """Find all moves that (14)-(17) and (38) alone would admit, whatever x, det H and the links do."""
    nothing = np.zeros(len(regions), dtype=np.int64)
    search = MoveSearch.of(regions, step_sizes(config.route), nothing, np.inf)
    return replace(search, needless=True).collect(silent)


@dataclass(frozen=True, eq=False)
class MoveSearch:
    """What decides which regions can be joined; `codes` as of `passing_codes`, one row per word.

    Attributes
    ----------
    origins, arrivals : (k,)
        Regions that are left, and the working mode one arrives in: their own and, at a gate, the other one as well.
    coordinates : list of (n,)
        Coordinates counted in steps; those that are whole numbers everywhere are left out, their cells say it all.
    needless : bool
        Whether moves that no route needs are found, too.
    """

    regions: RegionTable
    origins: IntArray
    arrivals: IntArray
    cells: Cells
    coordinates: list[FloatArray]
    codes: IntArray
    opposite: IntArray
    low_m: FloatArray
    high_m: FloatArray
    x_step_m: float
    needless: bool = False

    @classmethod
    def of(cls, regions: RegionTable, steps: FloatArray, codes: IntArray, x_step_m: float) -> "MoveSearch":
        """Sort the regions; `codes` are (n,) or (words, n), `x_step_m` is the largest move along X."""
        codes = np.atleast_2d(codes)
        left = np.repeat(np.arange(len(regions), dtype=np.int32), np.where(regions.gates > 0, 2, 1))
        origins = left[left != regions.goal]
        second = np.append(False, origins[1:] == origins[:-1])
        arrivals = regions.modes[origins] ^ np.where(second, gate_bit(regions.gates[origins]), 0)
        counted = regions.controlled[:, 1:] / steps[1:]
        whole = np.abs(counted - np.round(counted - counted[0]) - counted[0]).max(axis=0) < _ROUNDING
        low, high = regions.x_window_m.T.copy()
        return cls(
            regions=regions,
            origins=origins,
            arrivals=arrivals,
            cells=Cells.of(counted, regions.modes),
            coordinates=[counted[:, axis].copy() for axis in np.flatnonzero(~whole)],
            codes=codes,
            opposite=(codes >> _SHIFT) | ((codes & _LOW) << _SHIFT),
            low_m=low,
            high_m=high,
            x_step_m=x_step_m + _ROUNDING,
        )

    def collect(self, progress: Progress) -> Moves:
        """Find the moves of all origins, block by block."""
        tasks = [partial(self.moves_from, block) for block in blocks(len(self.origins), self._batch)]
        sources, targets = [], []
        for count, (source, target) in enumerate(in_parallel(tasks), start=1):
            progress("moves", count / len(tasks))
            sources.append(source)
            targets.append(target)
        whole = np.concatenate(sources)
        sources.clear()
        return Moves(whole, np.concatenate(targets))

    def expected_moves(self, sample: int = _SAMPLE) -> int:
        """Estimate the number of moves from a sample of origins, all of them where they are few."""
        count = len(self.origins)
        rows = np.linspace(0, count - 1, min(count, sample)).astype(np.int64)
        found = sum(len(self.moves_from(rows[block])[0]) for block in blocks(len(rows), self._batch))
        return round(found * count / max(len(rows), 1))

    @property
    def _batch(self) -> int:
        """Batch size in regions: fewer where many rows share a cell, of which each is a candidate for each."""
        return int(np.clip(_CANDIDATES / self.cells.candidates, 1, _BLOCK))

    def moves_from(self, block: slice | IntArray) -> tuple[IntArray, IntArray]:
        """Find the moves of a block of the origins: rows (m,) they leave and rows they arrive at."""
        origins = self.origins[block]
        number, j = self.cells.around(origins, self.arrivals[block])
        i = np.repeat(origins, number)
        # Opposite signs of det H, or of a passing pair of links, share a bit.
        keep = (self.codes[0][i] & self.opposite[0][j]) == 0
        keep &= (i != j) & (j != self.regions.start)
        if not self.needless:
            keep &= ~self._needless(i, j)
        i, j = i[keep], j[keep]
        for mine, other in zip(self.codes[1:], self.opposite[1:], strict=True):
            keep = (mine[i] & other[j]) == 0
            i, j = i[keep], j[keep]
        for coordinate in self.coordinates:
            near = np.abs(coordinate[i] - coordinate[j]) <= 1.0 + _ROUNDING
            i, j = i[near], j[near]
        apart = np.maximum(self.low_m[i] - self.high_m[j], self.low_m[j] - self.high_m[i])
        within = apart <= self.x_step_m
        return i[within], j[within]

    def _needless(self, i: IntArray, j: IntArray) -> BoolArray:
        """Mark moves (m,) between gates of one arm that change its mode: leaving the second can change it as well.

        A visit asks for the mode of its row. Without these moves a route that passes gates is one sequence, not many.
        """
        gates, modes = self.regions.gates, self.regions.modes
        same = (gates[i] > 0) & (gates[i] == gates[j]) & (self.regions.visits[j] == 0)
        return np.asarray(same & (modes[i] != modes[j]))


def passing_codes(machine: Machine, regions: RegionTable) -> IntArray:
    """Signs that two neighbouring regions must not have opposite, as bits. Shape (n,).

    Bits 0 to 15 stand for positive, bits 16 to 31 for negative: of the signed distance along the common
    perpendicular of each pair of links whose closest points lie inside both (neither bit otherwise), and last
    of det H.
    """
    tasks = [partial(_codes, machine, regions.take(block)) for block in blocks(len(regions), _CODES_BLOCK)]
    return np.concatenate([np.empty(0, dtype=np.int64), *in_parallel(tasks)])


def _codes(machine: Machine, regions: RegionTable) -> IntArray:
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
