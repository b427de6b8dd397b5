"""Bringing the largest kappa of a path down: sequential quadratic programming in actuator space.

The largest kappa is a slack variable t. A step solves, for changes d of the spline coefficients,

    minimise    w_1 (integral + its slope . d) / length of the coarse path + w_2 t + damping / 2 |d|^2
    subject to  kappa_k + its slope . d <= t at every look, aim <= t <= cap, every limit linearised,

a sparse convex program. Damping grows until the path that the step gives is as good as promised, and falls while steps
keep their promises. There are no poses among the unknowns, so that no equation has to be met and every iterate is a
path; the interior-point method that finds the least integral loses its way here, because kappa is at its bound along
much of a path.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_diag, csr_array, vstack

from pipeline.arrays import FloatArray
from pipeline.refine.peak.constraints import Limit, PathConstraints, of_actuators, pose_limits
from pipeline.refine.peak.iterate import EvaluationPoints, Iterate, iterate_at
from pipeline.refine.peak.speed import chord_curvature, chord_slopes, pace_limits
from pipeline.solvers import DampedProgram, interrupts_noted

_NEAR = 0.1
"""A bound farther than this (metres, radians, shares of the mean speed) from its value is left out of a step."""
_DAMPING_FIRST, _MORE, _LESS, _TRIALS = 500.0, 4.0, 0.4, 15
_KEPT, _WELL_KEPT = 0.1, 0.7
"""Share of the promised gain that a step has to bring, and from which on the next one may be longer."""
_LEAST_GAIN = 2e-5
"""Relative gain below which another step is not worth its time."""
_RESTORED, _RESTORING = 1e-7, 5
"""Excess, in units of the slack, that counts as none; steps that may be taken to get there."""


@dataclass(frozen=True)
class PeakObjective:
    """What is to be small: weights of the mean of kappa over `length` and of the largest kappa, aimed at and capped."""

    mean: float
    largest: float
    aim: float
    cap: float
    length: float

    def of(self, iterate: Iterate) -> float:
        """The value of a path."""
        largest = max(float(iterate.kappa.max()), self.aim)
        return self.mean * iterate.integral / self.length + self.largest * largest


@dataclass(frozen=True, eq=False)
class PeakProblem:
    """Where a descent takes place: the looks, what is demanded there, directions (2, 5), coefficient bounds (5, 2)."""

    looks: EvaluationPoints
    demands: PathConstraints
    directions: FloatArray
    actuator_limits_m: FloatArray

    def limits(self, iterate: Iterate) -> Iterator[Limit]:
        """All that an iterate has to keep."""
        yield from pose_limits(self.looks, self.demands, iterate)
        yield from pace_limits(self.looks, self.directions, iterate)

    def excess(self, iterate: Iterate) -> float:
        """By how much the worst limit is broken, in units of its slack."""
        return max(limit.excess for limit in self.limits(iterate))


@dataclass(frozen=True, eq=False)
class Descent:
    """Where a descent ended: the path, after how many steps, and whether no further one would bring anything."""

    iterate: Iterate
    steps: int
    converged: bool


def descend(ground: PeakProblem, wish: PeakObjective, start: Iterate, max_steps: int) -> Descent:
    """Take steps until they bring nothing more, or there have been too many of them."""
    iterate, damping = restore_feasibility(ground, start), _DAMPING_FIRST
    for steps in range(1, max_steps + 1):
        # CasADi swallows an interrupt that comes while it converts matrices.
        with interrupts_noted():
            taken = _step(ground, wish, iterate, damping)
        if taken is None:
            return Descent(restore_feasibility(ground, iterate), steps, True)
        iterate, damping = taken.iterate, taken.damping
        if abs(taken.promised) < _LEAST_GAIN * wish.of(iterate):
            return Descent(restore_feasibility(ground, iterate), steps, True)
        if taken.gain > _WELL_KEPT * taken.promised:
            damping *= _LESS
    return Descent(iterate, max_steps, False)


def restore_feasibility(ground: PeakProblem, iterate: Iterate) -> Iterate:
    """Take the least steps after which every limit is kept again, as far as that goes."""
    no_wish, excess = PeakObjective(0.0, 0.0, 0.0, np.inf, 1.0), ground.excess(iterate)
    for _ in range(_RESTORING):
        if excess <= _RESTORED:
            break
        with interrupts_noted():
            change, _ = _Subproblem(ground, no_wish, iterate).solve(1.0)
        tried = None if change is None else iterate_at(ground.looks, iterate.coefficients + change, iterate.pose)
        if tried is None or (left := ground.excess(tried)) >= excess:
            break
        iterate, excess = tried, left
    return iterate


@dataclass(frozen=True, eq=False)
class _Step:
    iterate: Iterate
    gain: float
    promised: float
    damping: float


def _step(ground: PeakProblem, wish: PeakObjective, iterate: Iterate, damping: float) -> _Step | None:
    """Find a step that keeps enough of its promise, with growing damping; None when there is none."""
    program, value, excess = _Subproblem(ground, wish, iterate), wish.of(iterate), ground.excess(iterate)
    for _ in range(_TRIALS):
        change, promised = program.solve(damping)
        tried = None if change is None else iterate_at(ground.looks, iterate.coefficients + change, iterate.pose)
        # Where limits were broken, mending them may cost something.
        least_gain = _KEPT * promised if promised > 0.0 else promised / _KEPT
        if tried is not None and _good(ground, wish, tried, value - least_gain, excess):
            return _Step(tried, value - wish.of(tried), promised, damping)
        damping *= _MORE
    return None


def _good(ground: PeakProblem, wish: PeakObjective, tried: Iterate, value: float, excess: float) -> bool:
    """Tell whether a path is within the slacks and no worse than `value`, or at least breaks limits much less."""
    broken = ground.excess(tried)
    return broken < excess / 2.0 if excess > 1.0 else broken <= 1.0 and wish.of(tried) <= value


class _Subproblem:
    """The quadratic program of a step from an iterate, to be solved with different damping."""

    def __init__(self, ground: PeakProblem, wish: PeakObjective, iterate: Iterate) -> None:
        self._iterate, self._wish = iterate, wish
        looks, size = ground.looks, iterate.coefficients.size
        by_kappa = of_actuators(looks, np.arange(len(looks.s)), iterate.kappa_slope)
        largest = np.zeros(size + 2)
        largest[size] = 1.0
        rows = [csr_array(by_kappa - csr_array(np.ones((len(looks.s), 1))) @ csr_array(largest[None]))]
        low, high = [np.full(len(looks.s), -np.inf)], [-iterate.kappa]
        for limit in ground.limits(iterate):
            near = np.flatnonzero((limit.value - limit.low < _NEAR) | (limit.high - limit.value < _NEAR))
            rows.append(limit.slope(near))
            low.append((limit.low - limit.value)[near])
            high.append((limit.high - limit.value)[near])
        gradient = wish.mean / wish.length * integral_slope(looks, iterate, by_kappa) + wish.largest * largest
        weights = wish.mean / wish.length * (iterate.kappa[1:] + iterate.kappa[:-1]) / 2.0
        self._program = DampedProgram(
            hessian=chord_curvature(looks, iterate, weights),
            damping=block_diag([looks.squared, csr_array((2, 2))]),
            gradient=gradient,
            matrix=vstack(rows),
            row_bounds=(np.concatenate(low), np.concatenate(high)),
            column_bounds=self._variable_bounds(ground.actuator_limits_m),
        )

    def _variable_bounds(self, actuator_limits_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        coefficients, wish = self._iterate.coefficients, self._wish
        low, high = (actuator_limits_m[:, side] - coefficients for side in (0, 1))
        for change in (low, high):
            change[[0, -1]] = 0.0
        length = float(self._iterate.distances.sum())
        cap = max(wish.cap, wish.aim)
        return np.append(low.ravel(), [wish.aim, -length / 2.0]), np.append(high.ravel(), [cap, length])

    def solve(self, damping: float) -> tuple[FloatArray | None, float]:
        """Find the change of the coefficients (n, 5) and what it promises; None where there is none."""
        x = self._program.solve(damping)
        if x is None:
            return None, 0.0
        before = self._wish.largest * max(float(self._iterate.kappa.max()), self._wish.aim)
        return x[:-2].reshape(-1, 5), before - self._program.value(x)


def integral_slope(looks: EvaluationPoints, iterate: Iterate, by_kappa: csr_array) -> FloatArray:
    """Differentiate the integral of the smooth kappa by the unknowns of a step. Shape (5 n + 2,)."""
    distances, kappa = iterate.distances, iterate.kappa
    shares = (np.append(distances, 0.0) + np.append(0.0, distances)) / 2.0
    slope: FloatArray = by_kappa.T @ shares + chord_slopes(looks, iterate).T @ ((kappa[1:] + kappa[:-1]) / 2.0)
    return slope
