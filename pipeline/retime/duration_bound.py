"""A lower bound on the duration without jerk limits, from a convex problem that is independent of the planner.

In x = sd^2, with x' = 2 sdd, limits a sdd + b sd^2 + c <= 1 are linear, and the duration, the integral of x^(-1/2), is
convex. Let x(s) keep the limits, with values X_k at the points of a grid and means m_k over the cells in between.
Weighting a limit with t = (s - s_k) / D, and with 1 - t, and integrating over a cell of width D gives

    a_(k+1) (X_(k+1) - m_k) / (2 D) + b_t m_k  <=  1 / 2 - c_t + e
    a_k     (m_k - X_k) / (2 D)     + b_t m_k  <=  1 / 2 - c_t + e

(by parts; b_t, c_t are means of t b, t c and of (1 - t) b, (1 - t) c; e bounds the difference between the mean of a
product and the product of means). By Jensen's inequality the duration is at least the sum of D m_k^(-1/2), and every
tangent of that is below it. So the minimum of a linear program, which has tangents only, is a lower bound for all
motions, not just for those of one mesh. The variation of coefficients within a cell is taken from both ends and the
middle.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_array

from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.retime.constraints import Rows, largest_speed, limit_rows, speed_caps
from pipeline.retime.path_dynamics import PathDynamicsTable

_ROUNDS = 10
_INFEASIBLE = 2
"""SciPy's status of a linear program without a solution."""
_TOLERANCE = 1e-5
"""Relative rise of the bound below which another linear program is not worth it."""
_LEAST = 1e-9
"""Least mean of x, relative to the largest possible, at which a tangent is taken."""


@dataclass(frozen=True, eq=False)
class BoundProgram:
    """Rows A y <= h in y = (X, m) / scale, 0 <= y <= 1, and the widths (k,) of the k cells.

    Every tangent of D m^(-1/2) at m > 0 is a lower bound on the time u that a cell takes:
    u >= (3 / 2) D m^(-1/2) - (1 / 2) D m^(-3/2) m'.
    """

    matrix: coo_array
    limit: FloatArray
    scale: FloatArray
    width: FloatArray


def duration_bound(table: PathDynamicsTable, s: FloatArray) -> float:
    """Compute a lower bound, in seconds, on the duration of every motion along the path from rest to rest.

    Parameters
    ----------
    s : (k + 1,)
        Grid from 0 to 1: the finer it is, the nearer the bound is to the shortest duration.

    Raises
    ------
    NoSolutionError
        When the linear program has no solution: then there is no motion at all.
    """
    return solve_bound(build_bound(table, s))


def build_bound(table: PathDynamicsTable, s: FloatArray) -> BoundProgram:
    """Build the rows that every motion satisfies in each of the k cells, without those that can never be active."""
    at_nodes, at_midpoints = table.at(s), table.at((s[1:] + s[:-1]) / 2.0)
    nodes, midpoints = limit_rows(at_nodes, outer=True), limit_rows(at_midpoints, outer=True)
    left, right = _part(nodes, slice(None, -1)), _part(nodes, slice(1, None))
    D = np.diff(s)[:, None]
    top = np.maximum(largest_speed(nodes), 0.0) ** 2
    cap = _mean_cap(speed_caps(at_nodes) ** 2, speed_caps(at_midpoints) ** 2)
    anywhere = np.maximum(np.maximum(top[1:], top[:-1]), largest_speed(midpoints) ** 2)
    top_mean = np.minimum(cap, anywhere)
    steepest = np.maximum.reduce([_steepest(rows, anywhere) for rows in (left, midpoints, right)])[:, None]
    # By parts x has the weights t b - (t a)' / 2 and the like. They deviate from their means by (b - a') (t - 1 / 2);
    # as x rises by no more than 2 steepest, its deviation from m makes at most steepest D / 6 of that.
    slope = (right.a - left.a) / D
    strayed = np.maximum.reduce([np.abs(part.b - slope) for part in (left, midpoints, right)])
    slack = strayed * steepest * D / 6.0
    reach = np.maximum(np.abs(left.a), np.abs(right.a)) * steepest
    reach += np.maximum(np.maximum(left.b, right.b), midpoints.b).clip(0.0) * top_mean[:, None]
    reach += np.maximum(np.maximum(left.c, right.c), midpoints.c)
    cell, row = np.nonzero((reach > 1.0) & np.isfinite(slack))
    entries, limit = [], []
    for side, end, sign in ((right, 1, 1.0), (left, 0, -1.0)):
        by_end = sign * side.a / (2.0 * D)
        by_mean = midpoints.b / 3.0 + side.b / 6.0 - by_end
        entries += [(by_end[cell, row], cell + end), (by_mean[cell, row], len(s) + cell)]
        limit.append((0.5 - midpoints.c / 3.0 - side.c / 6.0 + slack)[cell, row])
    # From rest to rest no motion is faster than the steepest rise and fall of x allow; this keeps the scales right.
    rise = np.concatenate([[0.0], np.cumsum(2.0 * steepest[:, 0] * D[:, 0])])
    top = np.minimum(top, np.minimum(rise, rise[-1] - rise))
    top_mean = np.minimum(top_mean, np.maximum(top[1:], top[:-1]) + steepest[:, 0] * D[:, 0])
    scale = np.concatenate([top, top_mean])
    count = len(cell)
    rows = np.concatenate([np.arange(count)] * 2 + [count + np.arange(count)] * 2)
    columns = np.concatenate([column for _, column in entries])
    values = np.concatenate([value for value, _ in entries]) * scale[columns]
    matrix = coo_array((values, (rows, columns)), shape=(2 * count, len(scale)))
    return BoundProgram(matrix, np.concatenate(limit), scale, np.diff(s))


def solve_bound(program: BoundProgram) -> float:
    """Raise the bound by tangents of the duration until it rises no more; it holds after any number of them.

    The first bound follows from the speed caps alone, and is kept if the solver gives up; rest satisfies all rows where
    no limit is used up by it, whatever the solver says.

    Raises
    ------
    NoSolutionError
        When the linear program has no solution.
    """
    cells, columns = len(program.width), len(program.scale)
    top = program.scale[-cells:]
    if not (top > 0.0).all():
        raise _no_motion()
    share, matrix, mean = program.width / np.sqrt(top), program.matrix.tocsr(), np.ones(cells)
    # Tolerances of the solver are absolute: it sees time in units of the first bound.
    unit_s, best = float(share.sum()), 1.0
    share = share / unit_s
    for _ in range(_ROUNDS):
        slope = 0.5 * share * mean**-1.5
        cost = np.concatenate([np.zeros(columns - cells), -slope])
        found = linprog(cost, A_ub=matrix, b_ub=program.limit, bounds=(0.0, 1.0), method="highs")
        if found.status == _INFEASIBLE and not (program.limit >= 0.0).all():
            raise _no_motion()
        if found.x is None:
            break
        before, best = best, max(best, float((1.5 * share * mean**-0.5).sum() + found.fun))
        if best < before * (1.0 + _TOLERANCE):
            break
        mean = np.maximum(found.x[-cells:], _LEAST)
    return best * unit_s


def _no_motion() -> NoSolutionError:
    return NoSolutionError(
        "retime",
        "no motion along the path keeps all limits: the program that bounds the duration has no solution",
        "Raise the limits that gravity or the curvature of the path uses up.",
    )


def _mean_cap(nodes: FloatArray, midpoints: FloatArray) -> FloatArray:
    """Bound the mean of x over each of k cells by caps at k + 1 nodes (k + 1, m) and k midpoints (k, m). Shape (k,).

    This is the least mean of any cap (Simpson's rule): the least cap itself has corners where two caps cross.
    """
    means = (nodes[:-1] + 4.0 * midpoints + nodes[1:]) / 6.0
    return np.asarray(means.min(axis=1))


def _part(rows: Rows, points: slice) -> Rows:
    return Rows(rows.a[points], rows.b[points], rows.c[points], rows.cap[points], rows.labels)


def _steepest(rows: Rows, top: FloatArray) -> FloatArray:
    """Compute the largest |sdd| that the rows allow for any x up to `top` (n,). Shape (n,)."""
    room = 1.0 - rows.c + np.maximum(-rows.b, 0.0) * top[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        up = np.where(rows.a > 0.0, room / rows.a, np.inf).min(axis=1)
        down = np.where(rows.a < 0.0, room / -rows.a, np.inf).min(axis=1)
    return np.asarray(np.maximum(up, down))
