"""The fastest trajectory under all limits but those of jerk, on a grid: TOPP-RA on the spline itself."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.refine.result import Path
from pipeline.retime.constraints import Rows, limit_rows
from pipeline.retime.holding_forces import pose_words
from pipeline.retime.path_dynamics import PathDynamicsTable, evaluate_dynamics, grid
from pipeline.retime.result import Trajectory
from pipeline.solvers.topp_ra import fastest_profile


def plan(path: Path, grid_points: int, table: PathDynamicsTable | None = None) -> Trajectory:
    """Find the fastest trajectory along the path, from rest to rest (TOPP-RA; Pham and Pham, 2018).

    Velocity limits hold at the grid points, limits of acceleration and force at both ends of every interval; the path
    acceleration is constant in between, so that the time law s(t) is piecewise quadratic. Kinematics and dynamics are
    evaluated at the grid points, or interpolated from a table.

    Raises
    ------
    NoSolutionError
        Where forces do not suffice to hold the machine at rest; otherwise there is a trajectory.
    """
    s = grid(grid_points)
    return plan_rows(path, s, limit_rows(evaluate_dynamics(path, s) if table is None else table.at(s)))


def plan_rows(path: Path, s: FloatArray, rows: Rows) -> Trajectory:
    """Find the fastest trajectory under limits that are known on a grid s (n,).

    Raises
    ------
    NoSolutionError
        Where a limit is used up at rest; otherwise there is a trajectory.
    """
    _require_rest(path, s, rows)
    sd, ds = fastest_profile(s, (rows.a, rows.b, rows.c), rows.cap), np.diff(s)
    return Trajectory.from_breakpoints(
        path,
        t_s=np.concatenate([[0.0], np.cumsum(2.0 * ds / (sd[1:] + sd[:-1]))]),
        s=s,
        sd=sd,
        sdd=np.append(np.diff(sd**2) / (2.0 * ds), 0.0),
    )


def _require_rest(path: Path, s: FloatArray, rows: Rows) -> None:
    point, row = np.unravel_index(np.argmax(rows.c), rows.c.shape)
    if rows.c[point, row] < 1.0:
        return
    name, subject = rows.labels[row]
    place = float(s[point])
    raise NoSolutionError(
        "retime",
        f"{subject} needs {rows.c[point, row]:.1%} of its {name.replace('_', ' ')} limit at rest at "
        f"s = {place:.4f}, at {pose_words(path.pose(place))}",
        "Raise machine.limits, lighten machine.dynamics (load_kg, platform), or ask for another path.",
        {"s": place, "actuator": subject, "limit": name},
    )
