"""Moves followed continuously: what lies between two neighbouring regions.

A move is the straight line in actuator space between two regions. It is admissible if the machine, taken along
it by forward kinematics, arrives at the pose of the second region, keeps the sign of det H and all limits of moves.
Travel and strokes hold in between if they hold at both ends.
Moving carts and pose along X changes nothing but the travel, so that a move holds at every x or at none. Near
boxes to avoid it is admitted only if it keeps out of them for every x of its regions' windows.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import Config
from pipeline.limits import DirectedLimit, Limit, applying, move_limits
from pipeline.limits.avoid import AvoidedBox, boxes_to_avoid
from pipeline.limits.bodies import obstacle_distance
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import follow
from pipeline.machine.samples import PoseSamples
from pipeline.route.metric import step_sizes
from pipeline.route.moves.bisection import ROUNDING, BisectionResult, LineSamples, bisect, sample_lines
from pipeline.route.moves.obstacle_passing import obstacles_hit
from pipeline.route.moves.rejections import BRANCH_REJECTIONS, Rejection
from pipeline.route.regions.boxes import grown_boxes
from pipeline.route.regions.table import RegionTable

_ARRIVAL = 1e-6
"""How far, in metres and radians, the marched pose may end from the region's: rounding, or another branch."""
_STILL_M = 1e-9
"""An actuator that moves no farther stands still."""
_BLOCK = 2048
"""Moves followed at a time."""
_MARCHED_POSES = 65_600
"""Poses marched through at a time."""


@dataclass(frozen=True, eq=False)
class MoveChecks:
    """What following moves (n,) showed.

    Attributes
    ----------
    rejections : list of n
        The first reason found to reject each move, None if it is admissible.
    kappa_max : (n,)
        Largest kappa of the samples, infinite where det H changes sign.
    """

    rejections: list[Rejection | None]
    kappa_max: FloatArray

    @property
    def good(self) -> BoolArray:
        """Which moves are admissible, shape (n,)."""
        return np.array([rejection is None for rejection in self.rejections], dtype=bool)


def check_moves(
    config: Config,
    machine: Machine,
    pose: FloatArray,
    q_m: FloatArray,
    limits: Sequence[Limit] | None = None,
    block: int = _BLOCK,
) -> MoveChecks:
    """Follow moves given by their two ends: poses (n, 2, 6) and actuator positions (n, 2, 5).

    `limits` are those to keep all along a move, `move_limits` by default; memory is bounded by working in blocks.
    """
    follower = _Follower.of(config, machine, move_limits(config, machine) if limits is None else limits)
    results = []
    for begin in range(0, len(pose), block):
        part = slice(begin, begin + block)
        ends = follower.sample(pose[part].reshape(-1, 6), q_m[part].reshape(-1, 5))
        results.append(follower.bisect(q_m[part], ends.at(np.arange(len(ends.pose)).reshape(-1, 2))))
    return follower.verdict(results, lambda rows: (pose[rows], q_m[rows]))


def check_pairs(
    config: Config,
    machine: Machine,
    regions: RegionTable,
    source: IntArray,
    target: IntArray,
    block: int = _BLOCK,
) -> MoveChecks:
    """Follow the moves between rows (n,) of the region table, whatever x of their windows they are made at.

    A move and its reverse are one line, which is followed once unless limits depend on the direction; memory is
    bounded by working in blocks.
    """
    # A few rows of a large table are all that is looked at.
    rows, numbers = np.unique([source, target], return_inverse=True)
    regions, (source, target) = regions.take(rows), numbers.reshape(2, -1)
    without_x = move_limits(config, machine, given_x=False)
    follower = _Follower.of(config, machine, without_x)
    pose, q = regions.pose, regions.q_m.copy()
    q[:, :3] -= pose[:, :1]
    pose[:, 0] = 0.0
    lines, line = np.unique(
        line_keys(source, target, len(regions), directed=is_directed(without_x)), return_inverse=True
    )
    ends = np.column_stack(np.divmod(lines, len(regions)))
    results = []
    for begin in range(0, len(ends), block):
        # A region is an end of many moves, and evaluated once.
        rows, pairs = np.unique(ends[begin : begin + block], return_inverse=True)
        pairs = pairs.reshape(-1, 2)
        results.append(follower.bisect(q[rows][pairs], follower.sample(pose[rows], q[rows]).at(pairs)))
    checks = follower.verdict(results, lambda rows: (pose[ends[rows]], q[ends[rows]]))
    for limit, entering in _boxes_entered(config, machine, regions, ends):
        for k in np.flatnonzero(entering):
            checks.rejections[k] = checks.rejections[k] or Rejection.of(limit)
    _reject_at_obstacles(config, machine, regions, ends, checks.rejections)
    return MoveChecks([checks.rejections[k] for k in line.tolist()], checks.kappa_max[line])


def _reject_at_obstacles(
    config: Config, machine: Machine, regions: RegionTable, ends: IntArray, rejections: list[Rejection | None]
) -> None:
    """Reject the moves between rows (n, 2), of those not rejected yet, that come too close to an obstacle."""
    for limit in obstacle_distance.for_moves(config, machine):
        rows = np.array([k for k, found in enumerate(rejections) if found is None], dtype=np.int64)
        hit = obstacles_hit(config, machine, regions, ends[rows])
        for k in rows[hit].tolist():
            rejections[k] = Rejection.of(limit)


def is_directed(limits: Sequence[Limit]) -> bool:
    """Tell whether a move may be admitted while its reverse is not."""
    one_way = np.zeros((1, 5))
    return any(isinstance(limit, DirectedLimit) and not limit.applies(one_way).all() for limit in limits)


def line_keys(source: IntArray, target: IntArray, regions: int, *, directed: bool) -> IntArray:
    """Number the lines between rows (n,) of a table: a move and its reverse alike, unless directed. Shape (n,)."""
    first, last = source.astype(np.int64), target.astype(np.int64)
    if not directed:
        first, last = np.minimum(first, last), np.maximum(first, last)
    keys: IntArray = first * regions + last
    return keys


def _boxes_entered(
    config: Config, machine: Machine, regions: RegionTable, ends: IntArray
) -> Iterator[tuple[AvoidedBox, BoolArray]]:
    """Find for every box which moves between rows (n, 2) enter it for some x of their windows. Shapes (n,).

    Where both ends are on one side of the box along X, the x nearest to it decides; elsewhere any x may be passed.
    """
    steps = step_sizes(config.route)
    for number, (box, grown) in enumerate(zip(boxes_to_avoid(config), grown_boxes(config), strict=True)):
        entering = np.zeros(len(ends), dtype=bool)
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
            limit = AvoidedBox(obstacle, number)
            found = check_moves(config, machine, pose, q, [limit]).rejections
            entering[rows[group]] |= np.array([reason == Rejection.of(limit) for reason in found], dtype=bool)
        yield AvoidedBox(box, number), entering


@dataclass(frozen=True, eq=False)
class _Follower:
    """Follows moves of one machine; `counts` holds the number of margins of each limit."""

    machine: Machine
    limits: Sequence[Limit]
    counts: list[int]
    max_samples: int

    @classmethod
    def of(cls, config: Config, machine: Machine, limits: Sequence[Limit]) -> "_Follower":
        no_poses = PoseSamples(machine, np.empty((0, 6)), np.empty((0, 5)))
        counts = [limit.margins(no_poses).shape[1] for limit in limits]
        return cls(machine, limits, counts, config.route.follow.max_samples)

    @property
    def rejections(self) -> list[Rejection]:
        """The reasons behind the margins, m of them."""
        rows = zip(self.limits, self.counts, strict=True)
        return [Rejection.of(limit) for limit, count in rows for _ in range(count)]

    def margins(self, samples: PoseSamples) -> FloatArray:
        """Compute all margins of n poses. Shape (n, m)."""
        return np.concatenate([limit.margins(samples) for limit in self.limits], axis=1)

    def sample(self, pose: FloatArray, q_m: FloatArray) -> LineSamples:
        """Evaluate poses (n, 6)."""
        return sample_lines(PoseSamples(self.machine, pose, q_m), self.margins)

    def bisect(self, q_m: FloatArray, ends: LineSamples) -> BisectionResult:
        """Follow lines between actuator positions (n, 2, 5) whose ends (n, 2) are known."""
        return bisect(self.machine, self.margins, self._applies(q_m), q_m, ends, self.max_samples)

    def _applies(self, q_m: FloatArray) -> BoolArray:
        """Tell which margins count on lines between actuator positions (n, 2, 5). Shape (n, m)."""
        change = q_m[:, 1] - q_m[:, 0]
        directions = np.where(np.abs(change) > _STILL_M, np.sign(change), 0.0)
        parts = [
            np.broadcast_to(applying(limit, directions), (len(q_m), count))
            for limit, count in zip(self.limits, self.counts, strict=True)
        ]
        return np.concatenate(parts, axis=1)

    def verdict(
        self,
        results: Sequence[BisectionResult],
        ends_of: Callable[[IntArray], tuple[FloatArray, FloatArray]],
    ) -> MoveChecks:
        """Join the results of all blocks, and march along doubtful lines; `ends_of` gives the ends of lines."""
        rejections = [found for part in results for found in self._first(part.broken)]
        kappa_max = np.concatenate([np.empty(0), *(part.kappa_max for part in results)])
        doubtful = np.flatnonzero(np.concatenate([np.empty(0, dtype=bool), *(part.doubtful for part in results)]))
        size = max(1, _MARCHED_POSES // (self.max_samples + 1))
        for begin in range(0, len(doubtful), size):
            rows = doubtful[begin : begin + size]
            marched = self._march(*ends_of(rows))
            kappa_max[rows] = marched.kappa_max
            for row, found in zip(rows, marched.rejections, strict=True):
                rejections[row] = found
        return MoveChecks(rejections, kappa_max)

    def _march(self, pose: FloatArray, q_m: FloatArray) -> MoveChecks:
        """March in equal steps from the first end (n, 2, 6) and compare the last pose with the second end."""
        part = np.linspace(0.0, 1.0, self.max_samples + 1)[:, None]
        q = q_m[:, :1] * (1.0 - part) + q_m[:, 1:] * part
        marched, misses = follow(self.machine, q, pose[:, 0])
        held = np.isfinite(misses)
        shape = held.shape
        # Where a line is lost its last pose stands in for the rest: nothing is found there a second time.
        last = np.maximum(np.count_nonzero(held, axis=1) - 1, 0)
        at = np.minimum(np.arange(shape[1]), last[:, None])
        q = np.take_along_axis(q, at[..., None], axis=1)
        samples = PoseSamples(self.machine, marched.reshape(-1, 6), q.reshape(-1, 5))
        inverse_kappa = samples.signed_inverse_kappa.reshape(shape)
        broken = (self.margins(samples) < -ROUNDING).reshape(*shape, -1).any(axis=1) & self._applies(q_m)
        signs = np.sign(inverse_kappa)
        of_branch = [
            ~held.all(axis=1),
            np.abs(marched[:, -1] - pose[:, 1]).max(axis=1) > _ARRIVAL,
            (signs != signs[:, :1]).any(axis=1),
        ]
        found = self._first(np.column_stack([*of_branch, broken]), BRANCH_REJECTIONS)
        with np.errstate(divide="ignore"):
            return MoveChecks(found, np.where(of_branch[2], np.inf, 1.0 / np.abs(inverse_kappa).min(axis=1)))

    def _first(self, found: BoolArray, before: Sequence[Rejection] = ()) -> list[Rejection | None]:
        """Return the first reason found per line; `found` (n, k) has a column per entry of `before` and per margin."""
        reasons = [*before, *self.rejections]
        first = np.where(found.any(axis=1), found.argmax(axis=1), -1)
        return [reasons[k] if k >= 0 else None for k in first.tolist()]
