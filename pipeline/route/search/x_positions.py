"""Choice of x for every step of a route: the mixed-integer program only needs one to exist.

Any x within the windows that moves at most Delta X per step (13) has the same sum (5), so the smoothest is taken:
the least sum of squared moves, a small quadratic program.
"""

from collections.abc import Callable

import numpy as np
from scipy.sparse import csc_array

from pipeline.arrays import FloatArray
from pipeline.solvers.highs import LinearProgram, Outcome, solve_program


def smoothest_x(
    windows_m: FloatArray,
    x_step_m: float,
    time_limit_s: float,
    feasible_m: FloatArray,
    solve: Callable[[LinearProgram, float], Outcome] = solve_program,
) -> FloatArray:
    """Choose x (n,) within windows (n, 2), at most `x_step_m` apart from step to step.

    `feasible_m` (n,) is known to satisfy both; it is returned when the quadratic program does not end optimal.
    """
    n = len(windows_m)
    difference = csc_array(np.diff(np.eye(n), axis=0))
    change = np.full(n - 1, x_step_m)
    program = LinearProgram(
        matrix=difference,
        cost=np.zeros(n),
        column_bounds=(windows_m[:, 0], windows_m[:, 1]),
        row_bounds=(-change, change),
        integer=np.zeros(n, dtype=bool),
        hessian=csc_array(np.tril((2.0 * difference.T @ difference).toarray())),
    )
    outcome = solve(program, time_limit_s)
    if not outcome.status.solved or outcome.values.size == 0:
        return feasible_m
    # The solver's tolerance must not put a cart beyond its rail.
    return np.clip(outcome.values, windows_m[:, 0], windows_m[:, 1])
