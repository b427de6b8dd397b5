"""Where along X each step of a route takes place: the mixed-integer program only needs it to exist.

Any x within the windows that moves at most Delta X per step (13) is as good for the sum (5), so the calmest is
taken: the least sum of squared moves, a small quadratic program.
"""

import highspy
import numpy as np
from scipy.sparse import csc_array

from pipeline.arrays import FloatArray
from pipeline.progress import silent
from pipeline.solvers.highs import make_model, solve_model


def smoothest_x(windows_m: FloatArray, x_step_m: float, time_limit_s: float, feasible_m: FloatArray) -> FloatArray:
    """Choose x (n,) within windows (n, 2), at most `x_step_m` apart from step to step.

    `feasible_m` (n,) is known to satisfy both; it is returned when the quadratic program does not end optimal.
    """
    n = len(windows_m)
    difference = csc_array(np.diff(np.eye(n), axis=0))
    square = np.tril((2.0 * difference.T @ difference).toarray())
    hessian = csc_array(square)
    change = np.full(n - 1, x_step_m)
    bounds = (windows_m[:, 0], windows_m[:, 1])
    model = make_model(difference, np.zeros(n), bounds, (-change, change), np.zeros(n, dtype=bool))
    model.hessian_.dim_ = n
    model.hessian_.format_ = highspy.HessianFormat.kTriangular
    model.hessian_.start_, model.hessian_.index_ = hessian.indptr, hessian.indices
    model.hessian_.value_ = hessian.data
    outcome = solve_model(model, time_limit_s, silent)
    if not outcome.status.solved or outcome.values.size == 0:
        return feasible_m
    # The solver's tolerance must not become a cart beyond its rail.
    return np.clip(outcome.values, windows_m[:, 0], windows_m[:, 1])
