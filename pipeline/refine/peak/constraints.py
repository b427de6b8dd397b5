"""What an iterate has to keep: values between bounds, and how they change with a step.

The unknowns of a step, in this order: changes of the coefficients (5 n), the largest kappa, the change of the length.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, hstack

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine.clearance import link_distances, link_rail_distances
from pipeline.machine.working_modes import reach_along_rails
from pipeline.refine.corridor import Corridor
from pipeline.refine.peak.iterate import EvaluationPoints, Iterate, slopes
from pipeline.route.metric import CONTROLLED

_POSE_SLACK, _CLEARANCE_SLACK_M, _SIDE_SLACK_M = 0.01, 0.0005, 0.001


@dataclass(frozen=True, eq=False)
class Limit:
    """Values (m,) to be kept between `low` and `high` (m,).

    `slope` gives the derivatives of some rows by the unknowns; `slack` is by how much a value may be beyond its bound
    on the way to the last iterate.
    """

    value: FloatArray
    low: FloatArray
    high: FloatArray
    slack: float
    slope: Callable[[IntArray], csr_array]

    @property
    def excess(self) -> float:
        """By how much it is broken at worst, in units of the slack; zero when it is kept."""
        return float(np.maximum(self.low - self.value, self.value - self.high).max(initial=0.0)) / self.slack


@dataclass(frozen=True, eq=False)
class PathConstraints:
    """What is asked of every iterate: the corridor at the looks, and least distances of the pairs there (k, pairs)."""

    corridor: Corridor
    link_m: FloatArray
    rail_m: FloatArray


def least_distances(distance_m: FloatArray, least_m: float, margin_m: float) -> FloatArray:
    """Give the least distances (k, pairs) to keep, from those of the path that is begun with.

    A pair nearer than the margin at the start or the goal, which are given, has the margin only where it had it.
    """
    wanted = np.full_like(distance_m, least_m + margin_m)
    near = (distance_m[[0, -1]] < least_m + margin_m).any(axis=0)
    wanted[:, near] = np.clip(distance_m[:, near], least_m, least_m + margin_m)
    return wanted


def pose_limits(looks: EvaluationPoints, demands: PathConstraints, iterate: Iterate) -> Iterator[Limit]:
    """Say what poses have to keep: the corridor, clearances, and the sides of the carts."""
    free = np.flatnonzero((demands.corridor.low < demands.corridor.high)[:, CONTROLLED].any(axis=1))
    yield _corridor(looks, demands.corridor, iterate)
    yield _clearance(looks, iterate, link_distances, demands.link_m, free)
    if np.isfinite(looks.machine.link_rail_m):
        yield _clearance(looks, iterate, link_rail_distances, demands.rail_m, free)
    if demands.corridor.sides.any():
        yield _sides(looks, demands.corridor, iterate)


def of_actuators(looks: EvaluationPoints, at: IntArray, slope: FloatArray) -> csr_array:
    """Turn derivatives (m, 5) by the actuators at the looks `at` (m,) into those by the unknowns, (m, 5 n + 2)."""
    rows, columns = np.repeat(np.arange(len(at)), 5), (5 * at[:, None] + np.arange(5)).ravel()
    by_q = csr_array((slope.ravel(), (rows, columns)), shape=(len(at), looks.spread.shape[0]))
    return csr_array(hstack([by_q @ looks.spread, csr_array((len(at), 2))]))


def _corridor(looks: EvaluationPoints, corridor: Corridor, iterate: Iterate) -> Limit:
    low, high, value = (a[1:-1, CONTROLLED].ravel() for a in (corridor.low, corridor.high, iterate.pose))

    def slope(rows: IntArray) -> csr_array:
        at, axis = rows // len(CONTROLLED) + 1, rows % len(CONTROLLED)
        return of_actuators(looks, at, iterate.moves[at, CONTROLLED[axis]])

    return Limit(value, low, high, _POSE_SLACK, slope)


def _clearance(
    looks: EvaluationPoints, iterate: Iterate, distances: Callable[..., FloatArray], least_m: FloatArray, free: IntArray
) -> Limit:
    pairs = least_m.shape[1]

    def between(pose: FloatArray, carts_m: FloatArray) -> FloatArray:
        return distances(looks.machine, pose, carts_m)

    def slope(rows: IntArray) -> csr_array:
        at = free[rows // pairs]
        every = slopes(between, iterate.pose[at], iterate.q_m[at], iterate.moves[at])
        return of_actuators(looks, at, every[np.arange(len(at)), rows % pairs])

    value = between(iterate.pose[free], iterate.q_m[free, :3]).ravel()
    return Limit(value, least_m[free].ravel(), np.full(len(value), np.inf), _CLEARANCE_SLACK_M, slope)


def _sides(looks: EvaluationPoints, corridor: Corridor, iterate: Iterate) -> Limit:
    look, arm = np.nonzero(corridor.sides)
    side = corridor.sides[look, arm]

    def reach(pose: FloatArray, carts_m: FloatArray) -> FloatArray:
        return reach_along_rails(looks.machine, pose, carts_m)

    def slope(rows: IntArray) -> csr_array:
        at = look[rows]
        every = slopes(reach, iterate.pose[at], iterate.q_m[at], iterate.moves[at])
        return of_actuators(looks, at, side[rows, None] * every[np.arange(len(at)), arm[rows]])

    value = side * reach(iterate.pose, iterate.q_m[:, :3])[look, arm]
    low = np.full(len(value), corridor.side_margin_m)
    return Limit(value, low, np.full(len(value), np.inf), _SIDE_SLACK_M, slope)
