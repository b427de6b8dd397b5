"""What the poses of an iterate have to keep: values between bounds, and their derivatives by a step.

The unknowns of a step, in this order: changes of the coefficients (5 n), the largest kappa, the change of the length.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.sparse import csr_array

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.limits import DivisibleLimit, NodeLimit
from pipeline.machine.pose import CONTROLLED
from pipeline.refine.corridor.cells import Corridor
from pipeline.refine.corridor.cone import Walls
from pipeline.refine.peak.iterate import EvaluationPoints, Iterate
from pipeline.refine.splines import DEGREE

_POSE_SLACK, _SIDE_SLACK_M, _WALL_SLACK_M = 0.01, 0.001, 0.001


@dataclass(frozen=True, eq=False)
class Constraint:
    """Values (m,) to be kept between `low` and `high` (m,).

    `slope` gives the derivatives of some rows by the unknowns; `slack` is how far a value may be beyond its bound
    before the last iterate, and a bound farther than `near` from its value (metres, radians, shares of the mean speed)
    is left out of a step.
    """

    value: FloatArray
    low: FloatArray
    high: FloatArray
    slack: float
    slope: Callable[[IntArray], csr_array]
    near: float = 0.1

    @property
    def excess(self) -> float:
        """How far the worst value is beyond its bound, in units of the slack; zero if all are kept."""
        return float(np.maximum(self.low - self.value, self.value - self.high).max(initial=0.0)) / self.slack


@dataclass(frozen=True, eq=False)
class LeastValues:
    """A limit, and the least values (k, m) to keep at the evaluation points."""

    limit: NodeLimit
    least: FloatArray


@dataclass(frozen=True, eq=False)
class PathConstraints:
    """What every iterate has to keep at its k evaluation points: the corridor, and the least values of limits."""

    corridor: Corridor
    limits: Sequence[LeastValues]


def least_values(limit: NodeLimit, values: FloatArray, margin: float, counts: BoolArray) -> LeastValues:
    """Choose the least values to keep, given those (k, m) of the path that the descent starts from.

    What is within the margin at the start or the goal, which are given, keeps the margin only where it has it. Values
    that do not count (`counts`, (k, m)) may be anything.
    """
    wanted = np.full_like(values, limit.least + margin)
    near = (values[[0, -1]] < limit.least + margin).any(axis=0)
    wanted[:, near] = np.clip(values[:, near], limit.least, limit.least + margin)
    wanted[~np.broadcast_to(counts, values.shape)] = -np.inf
    return LeastValues(limit, wanted)


def pose_constraints(points: EvaluationPoints, required: PathConstraints, iterate: Iterate) -> Iterator[Constraint]:
    """Write what poses have to keep: the corridor, the limits, the sides of the carts, the cones of straight ends."""
    free = np.flatnonzero((required.corridor.low < required.corridor.high)[:, CONTROLLED].any(axis=1))
    yield _corridor(points, required.corridor, iterate)
    for limit in required.limits:
        yield _limit(points, limit, iterate, free)
    if required.corridor.sides.any():
        yield _sides(points, required.corridor, iterate)
    if len(required.corridor.walls):
        yield _walls(points, required.corridor.walls, iterate)


def by_unknowns(points: EvaluationPoints, at: IntArray, slope: FloatArray) -> csr_array:
    """Turn derivatives (m, 5) by the actuators at the points `at` (m,) into those by the unknowns, (m, 5 n + 2)."""
    width = DEGREE + 1
    columns, values = (part.reshape(-1, width)[at, :, None] for part in (points.basis.indices, points.basis.data))
    indices, data = (5 * columns + np.arange(5)).ravel(), (values * slope[:, None, :]).ravel()
    begins = 5 * width * np.arange(len(at) + 1)
    return csr_array((data, indices, begins), shape=(len(at), 5 * points.coefficients + 2))


def _corridor(points: EvaluationPoints, corridor: Corridor, iterate: Iterate) -> Constraint:
    low, high, value = (a[1:-1, CONTROLLED].ravel() for a in (corridor.low, corridor.high, iterate.samples.pose))

    def slope(rows: IntArray) -> csr_array:
        at, axis = rows // len(CONTROLLED) + 1, rows % len(CONTROLLED)
        return by_unknowns(points, at, iterate.moves[at, CONTROLLED[axis]])

    return Constraint(value, low, high, _POSE_SLACK, slope)


def _limit(points: EvaluationPoints, required: LeastValues, iterate: Iterate, free: IntArray) -> Constraint:
    """Keep the values of a limit at the points `free` (m,), whose poses are not given."""
    limit, least = required.limit, required.least[free]
    count = least.shape[1]

    def slope(rows: IntArray) -> csr_array:
        return by_unknowns(points, free[rows // count], _slopes(limit, iterate, free[rows // count], rows % count))

    value = _values(required, iterate)[free].ravel()
    return Constraint(value, least.ravel(), np.full(len(value), np.inf), limit.slack, slope, limit.near)


@lru_cache(maxsize=16)
def _values(required: LeastValues, iterate: Iterate) -> FloatArray:
    """Compute the values (k, m) of a limit; the last results are kept, since an iterate is looked at several times."""
    return required.limit.values(iterate.samples)


def _slopes(limit: NodeLimit, iterate: Iterate, at: IntArray, column: IntArray) -> FloatArray:
    """Differentiate values of a limit by the actuators, each of a column (n,) at a point (n,). Shape (n, 5)."""
    if not isinstance(limit, DivisibleLimit):
        return iterate.slopes(limit.values)[at, column]
    points, here = np.unique(at, return_inverse=True)
    columns, there = np.unique(column, return_inverse=True)
    return iterate.slopes_at(points, limit.only(columns).values)[here, there]


def _sides(points: EvaluationPoints, corridor: Corridor, iterate: Iterate) -> Constraint:
    point, arm = np.nonzero(corridor.sides)
    side = corridor.sides[point, arm]

    def slope(rows: IntArray) -> csr_array:
        by_q = iterate.slopes(lambda samples: samples.reach_m)[point[rows], arm[rows]]
        return by_unknowns(points, point[rows], side[rows, None] * by_q)

    value = side * iterate.samples.reach_m[point, arm]
    low = np.full(len(value), corridor.side_margin_m)
    return Constraint(value, low, np.full(len(value), np.inf), _SIDE_SLACK_M, slope)


def _walls(points: EvaluationPoints, walls: Walls, iterate: Iterate) -> Constraint:
    def slope(rows: IntArray) -> csr_array:
        at = walls.node[rows]
        return by_unknowns(points, at, np.einsum("ki,kij->kj", walls.normal[rows], iterate.moves[at, :3]))

    value = np.einsum("ki,ki->k", walls.normal, iterate.samples.pose[walls.node, :3])
    return Constraint(value, np.full(len(value), -np.inf), walls.offset, _WALL_SLACK_M, slope)
