"""Choice of x for every step of a route whose regions are known.

Where x costs nothing, as in the sum (5), any x within the windows that moves at most Delta X per step (13) will do, and
the smoothest is taken: the least sum of squared moves, a small quadratic program. Where it costs, the cheapest is.
"""

from collections.abc import Callable

import numpy as np
from scipy.sparse import csc_array

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.cost.objectives import route_cost
from pipeline.route.problem import RouteProblem
from pipeline.route.regions.table import RegionTable
from pipeline.solvers.highs import LinearProgram, Outcome, solve_program

_LEAST_S = 1.0
"""Seconds that a program of one sequence may take even when the time is up: it takes milliseconds."""
_MOST_CUTS = 100
"""Tangents of a move at most; a dozen do."""

_Tangent = tuple[FloatArray, FloatArray]
"""Costs of n moves at no travel, and their slopes, (n,) each."""


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


def cheapest_x(
    problem: RouteProblem, regions: RegionTable, rows: IntArray, close: float = 1e-10
) -> tuple[FloatArray, float] | None:
    """Choose the x (n,) of least cost for rows (n,) of a table, to a relative precision of `close`; with its cost.

    Kelley's cutting planes: linear programs over tangents of the moves' costs, which are convex in their travel, until
    the cost is that of the tangents. None: no x keeps the windows, (13) and the budgets.
    """
    regions, rows = regions.take(rows), np.arange(len(rows))
    ends = regions, rows[:-1], rows[1:]
    tangents = [problem.cost.tangent(*ends, travel) for travel in problem.cost.first_travel(*ends, 0.0)]
    best: tuple[FloatArray, float] | None = None
    for _ in range(_MOST_CUTS):
        outcome = solve_program(_x_program(problem, regions, tangents), max(problem.deadline.left_s, _LEAST_S))
        if not outcome.status.solved or outcome.values.size == 0:
            return best
        # The solver's tolerance must not put a cart beyond its rail.
        x = np.clip(outcome.values[: len(rows)], *regions.x_window_m[rows].T)
        cost = route_cost(problem.cost, regions, rows, x)
        if best is None or cost < best[1]:
            best = x, cost
        if best[1] - outcome.objective <= close * abs(best[1]):
            break
        tangents.append(problem.cost.tangent(*ends, np.diff(x)))
    return best


def _x_program(problem: RouteProblem, regions: RegionTable, tangents: list[_Tangent]) -> LinearProgram:
    """Write the linear program of tangents, for n rows in their order: x, then the cost and the |dx| of each move."""
    n, moves = len(regions), len(regions) - 1
    ends = regions, np.arange(moves), np.arange(1, n)
    change, eye, none = np.diff(np.eye(n), axis=0), np.eye(moves), np.zeros((moves, moves))
    step = problem.options.x_step_m
    low, high = regions.x_window_m.T
    blocks = [[change, none, none], [change, none, -eye], [-change, none, -eye]]
    row_low = [np.full(moves, -step), np.full(2 * moves, -np.inf)]
    row_high = [np.full(moves, step), np.zeros(2 * moves)]
    for constant, slope in tangents:
        blocks.append([-slope[:, None] * change, eye, none])
        row_low.append(constant)
        row_high.append(np.full(moves, np.inf))
    for budget in problem.budgets:
        if budget.travels:
            blocks.append([np.zeros((1, n)), np.zeros((1, moves)), np.ones((1, moves))])
            row_low.append(np.array([-np.inf]))
            row_high.append(np.array([budget.limit - budget.used(*ends).sum()]))
    return LinearProgram(
        matrix=csc_array(np.block(blocks)),
        cost=np.concatenate([np.zeros(n), np.ones(moves), np.zeros(moves)]),
        column_bounds=(np.concatenate([low, np.zeros(2 * moves)]), np.concatenate([high, np.full(2 * moves, np.inf)])),
        row_bounds=(np.concatenate(row_low), np.concatenate(row_high)),
        integer=np.zeros(n + 2 * moves, dtype=bool),
    )
