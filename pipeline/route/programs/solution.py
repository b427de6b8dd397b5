"""Solving a program of stage one: one region and one x per step, whatever the program's unknowns are."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.progress import QUIET, Monitor
from pipeline.solvers.highs import LinearProgram, Outcome, solve_program, solver_name

Read = Callable[[FloatArray], tuple[IntArray, FloatArray]]
"""Reads the region and the x of every step (N,) from a solution's values."""


@dataclass(frozen=True, eq=False)
class StepSequence:
    """A solution: the region and the x of every step up to the first at the goal; empty without a feasible point.

    `columns` counts those of the program, and `solver` is what solved it.
    """

    region: IntArray
    x_m: FloatArray
    outcome: Outcome
    columns: int
    solver: str = field(default_factory=solver_name)


def solve_steps(
    program: LinearProgram, read: Read, time_limit_s: float, monitor: Monitor = QUIET, relative_gap: float = 0.0
) -> StepSequence:
    """Solve a program whose last step is at the goal (10)-(11)."""
    outcome = solve_program(program, time_limit_s, monitor, relative_gap)
    if outcome.values.size == 0:
        return StepSequence(np.empty(0, dtype=np.int64), np.empty(0), outcome, program.columns)
    region, x = read(outcome.values)
    length = int(np.argmax(region == region[-1])) + 1
    return StepSequence(region[:length], x[:length], outcome, program.columns)
