"""Lowering the largest kappa of a path: sequential quadratic programming in actuator space.

Damping of the steps (`step`) grows until a step brings enough of the gain that its program predicts, and falls while
steps bring most of it. There are no poses among the unknowns, so that no equation has to be met and every iterate is a
path. The interior-point method that finds the least integral gets lost here, because kappa is at its bound along much
of a path.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from pipeline.arrays import FloatArray
from pipeline.refine.peak.iterate import Iterate, iterate_at
from pipeline.refine.peak.problem import PeakObjective, PeakProblem
from pipeline.refine.peak.step import StepProgram
from pipeline.solvers import interrupts_noted

_DAMPING_FIRST, _MORE, _LESS, _TRIALS = 500.0, 4.0, 0.4, 15
_KEPT, _WELL_KEPT = 0.1, 0.7
"""Share of the predicted gain that a step has to bring, and from which on the next one may be longer."""
_LEAST_GAIN = 2e-5
"""Relative gain below which another step is not worth its time."""
_RESTORED, _RESTORING = 1e-7, 5
"""Excess, in units of the slack, that counts as none; most steps taken to get there."""


@dataclass(frozen=True, eq=False)
class Descent:
    """Where a descent ended: the iterate, after how many steps, and whether a further one would bring nothing."""

    iterate: Iterate
    steps: int
    converged: bool


def descend(problem: PeakProblem, objective: PeakObjective, initial: Iterate, max_steps: int) -> Descent:
    """Take steps until they bring nothing more, or there have been too many of them."""
    iterate, damping = restore_feasibility(problem, initial), _DAMPING_FIRST
    for steps in range(1, max_steps + 1):
        # CasADi swallows an interrupt that comes while it converts matrices.
        with interrupts_noted():
            step = _step(problem, objective, iterate, damping)
        if step is None:
            return Descent(restore_feasibility(problem, iterate), steps, True)
        iterate, damping = step.iterate, step.damping
        if abs(step.predicted) < _LEAST_GAIN * objective.value(iterate):
            return Descent(restore_feasibility(problem, iterate), steps, True)
        if step.gain > _WELL_KEPT * step.predicted:
            damping *= _LESS
    return Descent(iterate, max_steps, False)


def restore_feasibility(problem: PeakProblem, iterate: Iterate) -> Iterate:
    """Take the shortest steps after which every constraint is kept again, as far as that is possible."""
    size, excess = iterate.coefficients.size, problem.excess(iterate)
    nothing = PeakObjective(0.0, 0.0, 0.0, np.inf, 1.0, csr_array((size, size)))
    for _ in range(_RESTORING):
        if excess <= _RESTORED:
            break
        with interrupts_noted():
            change, _ = StepProgram(problem, nothing, iterate).solve(1.0)
        tried = None if change is None else _moved(problem, iterate, change)
        if tried is None or (left := problem.excess(tried)) >= excess:
            break
        iterate, excess = tried, left
    return iterate


@dataclass(frozen=True, eq=False)
class _Step:
    iterate: Iterate
    gain: float
    predicted: float
    damping: float


def _step(problem: PeakProblem, objective: PeakObjective, iterate: Iterate, damping: float) -> _Step | None:
    """Find a step that brings enough of its predicted gain, with growing damping; None if there is none."""
    program = StepProgram(problem, objective, iterate)
    value, excess = objective.value(iterate), problem.excess(iterate)
    for _ in range(_TRIALS):
        change, predicted = program.solve(damping)
        tried = None if change is None else _moved(problem, iterate, change)
        # Where constraints were broken, restoring them may cost something.
        least_gain = _KEPT * predicted if predicted > 0.0 else predicted / _KEPT
        if tried is not None and _acceptable(problem, objective, tried, value - least_gain, excess):
            return _Step(tried, value - objective.value(tried), predicted, damping)
        damping *= _MORE
    return None


def _moved(problem: PeakProblem, iterate: Iterate, change: FloatArray) -> Iterate | None:
    return iterate_at(problem.points, iterate.coefficients + change, iterate.samples.pose)


def _acceptable(problem: PeakProblem, objective: PeakObjective, tried: Iterate, most: float, excess: float) -> bool:
    """Return whether a path is within the slacks and its value at most `most`, or it is far less infeasible."""
    broken = problem.excess(tried)
    return broken < excess / 2.0 if excess > 1.0 else broken <= 1.0 and objective.value(tried) <= most
