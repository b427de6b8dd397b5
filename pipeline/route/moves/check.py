"""Moves followed continuously: what lies between two neighbouring regions.

A move is the straight line in actuator space between two regions. It is good when the machine, taken along
it by forward kinematics, arrives at the pose of the second region with the sign of det H, the kappa cap, the
clearance and the tilt limit kept all the way. Travel and strokes hold between when they hold at both ends.
Moving carts and pose along X changes nothing but the travel, so that a move holds at every x or at none. Where there
are boxes to avoid it is admitted only when it keeps out of them for every x of its regions' windows.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import Config
from pipeline.machine.clearance import link_distances, link_pairs, link_rail_distances, rail_pairs
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import follow
from pipeline.route.metric import CONTROLLED, step_sizes
from pipeline.route.moves.bisection import ROUNDING, Halved, Look, Margins, halve, look, signed_regularity
from pipeline.route.regions.boxes import Box, boxes_to_avoid, grown_boxes
from pipeline.route.regions.table import RegionTable

_ARRIVAL = 1e-6
"""How far, in metres and radians, the marched pose may end from the region's: rounding, or another branch."""
_TILTS = [3, 5]
_BLOCK = 2048
_MARCHED_BLOCK = 64


class Flaw(StrEnum):
    """Why a move is not admissible when followed continuously."""

    LOST = "the closure equations lose their solution"
    ELSEWHERE = "it ends on another branch of the forward kinematics"
    SINGULAR = "det H changes sign"
    KAPPA = "kappa exceeds its cap"
    LINKS = "links come too close"
    RAILS = "a link comes too close to a rail"
    TILT = "the platform tilts too far"
    BOX = "the TCP enters a box to avoid"


_WAYS = (Flaw.LOST, Flaw.ELSEWHERE, Flaw.SINGULAR)
"""What can be wrong with the way itself, before any limit."""


@dataclass(frozen=True, eq=False)
class MoveChecks:
    """What following moves (n,) showed.

    Attributes
    ----------
    flaw : list of n
        The first of the reasons found, None for none.
    kappa_max : (n,)
        Largest kappa of the poses looked at, infinite where det H changes sign.
    """

    flaw: list[Flaw | None]
    kappa_max: FloatArray

    @property
    def good(self) -> BoolArray:
        """Which moves are admissible, shape (n,)."""
        return np.array([flaw is None for flaw in self.flaw], dtype=bool)


def check_moves(
    config: Config, machine: Machine, pose: FloatArray, q_m: FloatArray, boxes: list[Box] | None = None
) -> MoveChecks:
    """Follow moves given by their two ends: poses (n, 2, 6) and actuator positions (n, 2, 5).

    `boxes` are those to avoid, `task.avoid` by default.
    """
    follower = _Follower.of(config, machine, boxes_to_avoid(config) if boxes is None else boxes)
    halved = []
    for begin in range(0, len(pose), _BLOCK):
        block = slice(begin, begin + _BLOCK)
        ends = follower.look(pose[block].reshape(-1, 6), q_m[block].reshape(-1, 5))
        halved.append(follower.halve(q_m[block], ends.at(np.arange(len(ends.pose)).reshape(-1, 2))))
    return follower.verdict(halved, lambda rows: (pose[rows], q_m[rows]))


def check_pairs(
    config: Config, machine: Machine, regions: RegionTable, source: IntArray, target: IntArray
) -> MoveChecks:
    """Follow the moves between rows (n,) of the region table, whatever x of their windows they are made at.

    A move and its reverse are one line, which is followed once; memory is bounded by working in blocks.
    """
    follower = _Follower.of(config, machine, [])
    pose, q = regions.pose, regions.q_m.copy()
    q[:, :3] -= pose[:, :1]
    pose[:, 0] = 0.0
    low, high = np.minimum(source, target).astype(np.int64), np.maximum(source, target).astype(np.int64)
    lines, line = np.unique(low * len(regions) + high, return_inverse=True)
    ends = np.column_stack(np.divmod(lines, len(regions)))
    halved = []
    for begin in range(0, len(ends), _BLOCK):
        # A region is an end of many moves, and looked at once.
        rows, pairs = np.unique(ends[begin : begin + _BLOCK], return_inverse=True)
        pairs = pairs.reshape(-1, 2)
        halved.append(follower.halve(q[rows][pairs], follower.look(pose[rows], q[rows]).at(pairs)))
    checks = follower.verdict(halved, lambda rows: (pose[ends[rows]], q[ends[rows]]))
    for k in np.flatnonzero(_entering(config, machine, regions, ends)):
        checks.flaw[k] = checks.flaw[k] or Flaw.BOX
    return MoveChecks([checks.flaw[k] for k in line.tolist()], checks.kappa_max[line])


def _entering(config: Config, machine: Machine, regions: RegionTable, ends: IntArray) -> BoolArray:
    """Tell which moves between rows (n, 2) enter a box to avoid for some x of their windows. Shape (n,).

    Where both ends are on one side of the box along X, the x nearest to it decides; elsewhere any x may be passed.
    """
    entering, steps = np.zeros(len(ends), dtype=bool), step_sizes(config.route)
    for box, grown in zip(boxes_to_avoid(config), grown_boxes(config), strict=True):
        near = grown.near(regions.controlled, steps)
        rows = np.flatnonzero(near[ends].any(axis=1))
        least, largest = regions.x_window_m[ends[rows], 0].min(axis=1), regions.x_window_m[ends[rows], 1].max(axis=1)
        below, above = largest <= grown.low[0] + ROUNDING, least >= grown.high[0] - ROUNDING
        for group, x, obstacle in (
            (below, largest, box),
            (above & ~below, least, box),
            (~below & ~above, largest, box.across()),
        ):
            pose, q = regions.pose[ends[rows[group]]], regions.q_m[ends[rows[group]]]
            q[..., :3] += (x[group, None] - pose[..., 0])[..., None]
            pose[..., 0] = x[group, None]
            flaws = check_moves(config, machine, pose, q, [obstacle]).flaw
            entering[rows[group]] |= np.array([flaw is Flaw.BOX for flaw in flaws], dtype=bool)
    return entering


@dataclass(frozen=True, eq=False)
class _Limit:
    """A limit that holds all along a move: the flaw of a move that breaks it, and how many margins it has."""

    flaw: Flaw
    columns: int
    margins: Margins


def _limits(config: Config, machine: Machine, boxes: list[Box]) -> list[_Limit]:
    """The limits in the order in which they are told."""
    least = 1.0 / config.route.kappa_max
    tilt_max = np.deg2rad(config.task.tilt_max_deg + config.route.follow.tilt_overshoot_deg)
    links, rails = len(link_pairs(machine)), len(rail_pairs(machine))

    def kappa(pose: FloatArray, q_m: FloatArray, regularity: FloatArray) -> FloatArray:
        return regularity[:, None] - least

    def between_links(pose: FloatArray, q_m: FloatArray, regularity: FloatArray) -> FloatArray:
        return link_distances(machine, pose, q_m[:, :3]) - machine.link_link_m

    def to_rails(pose: FloatArray, q_m: FloatArray, regularity: FloatArray) -> FloatArray:
        return link_rail_distances(machine, pose, q_m[:, :3]) - machine.link_rail_m

    def tilt(pose: FloatArray, q_m: FloatArray, regularity: FloatArray) -> FloatArray:
        return np.concatenate([tilt_max - pose[:, _TILTS], tilt_max + pose[:, _TILTS]], axis=1)

    limits = [_Limit(Flaw.KAPPA, 1, kappa), _Limit(Flaw.LINKS, links, between_links)]
    if not np.isnan(machine.link_rail_m):
        limits.append(_Limit(Flaw.RAILS, rails, to_rails))
    limits.append(_Limit(Flaw.TILT, 2 * len(_TILTS), tilt))
    return limits + [_Limit(Flaw.BOX, 1, _outside(box)) for box in boxes]


def _outside(box: Box) -> Margins:
    def margin(pose: FloatArray, q_m: FloatArray, regularity: FloatArray) -> FloatArray:
        return -box.depth_m(pose[:, CONTROLLED])[:, None]

    return margin


@dataclass(frozen=True, eq=False)
class _Follower:
    """Follows moves of one machine; `flaws` (m,) names the flaw of each margin."""

    machine: Machine
    limits: list[_Limit]
    flaws: list[Flaw]
    max_samples: int

    @classmethod
    def of(cls, config: Config, machine: Machine, boxes: list[Box]) -> "_Follower":
        limits = _limits(config, machine, boxes)
        flaws = [limit.flaw for limit in limits for _ in range(limit.columns)]
        return cls(machine, limits, flaws, config.route.follow.max_samples)

    def margins(self, pose: FloatArray, q_m: FloatArray, regularity: FloatArray) -> FloatArray:
        """All margins of poses (n, 6) at actuator positions (n, 5) with 1/kappa (n,). Shape (n, m)."""
        return np.concatenate([limit.margins(pose, q_m, regularity) for limit in self.limits], axis=1)

    def look(self, pose: FloatArray, q_m: FloatArray) -> Look:
        """See what there is at poses (n, 6)."""
        return look(self.machine, self.margins, pose, q_m)

    def halve(self, q_m: FloatArray, ends: Look) -> Halved:
        """Follow lines between actuator positions (n, 2, 5) whose ends (n, 2) are known."""
        return halve(self.machine, self.margins, q_m, ends, self.max_samples)

    def verdict(
        self, halved: Sequence[Halved], ends_of: Callable[[IntArray], tuple[FloatArray, FloatArray]]
    ) -> MoveChecks:
        """Put blocks of lines together, and march along the doubtful ones; `ends_of` gives the ends of lines."""
        flaw = [found for part in halved for found in self._first(part.broken)]
        kappa_max = np.concatenate([np.empty(0), *(part.kappa_max for part in halved)])
        doubtful = np.flatnonzero(np.concatenate([np.empty(0, dtype=bool), *(part.doubtful for part in halved)]))
        for begin in range(0, len(doubtful), _MARCHED_BLOCK):
            rows = doubtful[begin : begin + _MARCHED_BLOCK]
            marched = self._march(*ends_of(rows))
            kappa_max[rows] = marched.kappa_max
            for row, found in zip(rows, marched.flaw, strict=True):
                flaw[row] = found
        return MoveChecks(flaw, kappa_max)

    def _march(self, pose: FloatArray, q_m: FloatArray) -> MoveChecks:
        """March from the first end (n, 2, 6) on in equal steps, and see where that leads."""
        part = np.linspace(0.0, 1.0, self.max_samples + 1)[:, None]
        q = q_m[:, :1] * (1.0 - part) + q_m[:, 1:] * part
        marched, misses = follow(self.machine, q, pose[:, 0])
        held = np.isfinite(misses)
        shape = held.shape
        # Where a line is lost its last pose stands in for the rest: nothing is found there a second time.
        last = np.maximum(np.count_nonzero(held, axis=1) - 1, 0)
        at = np.minimum(np.arange(shape[1]), last[:, None])
        q = np.take_along_axis(q, at[..., None], axis=1)
        regularity = signed_regularity(self.machine, marched, q)
        flat = marched.reshape(-1, 6), q.reshape(-1, 5), np.abs(regularity).reshape(-1)
        broken = (self.margins(*flat) < -ROUNDING).reshape(*shape, -1).any(axis=1)
        signs = np.sign(regularity)
        ways = [
            ~held.all(axis=1),
            np.abs(marched[:, -1] - pose[:, 1]).max(axis=1) > _ARRIVAL,
            (signs != signs[:, :1]).any(axis=1),
        ]
        flaw = self._first(np.column_stack([*ways, broken]), _WAYS)
        with np.errstate(divide="ignore"):
            return MoveChecks(flaw, np.where(ways[2], np.inf, 1.0 / np.abs(regularity).min(axis=1)))

    def _first(self, found: BoolArray, before: Sequence[Flaw] = ()) -> list[Flaw | None]:
        """The first flaw found per line; `found` (n, k) has a column per entry of `before` and per margin."""
        names = [*before, *self.flaws]
        first = np.where(found.any(axis=1), found.argmax(axis=1), -1)
        return [names[k] if k >= 0 else None for k in first.tolist()]
