"""The fastest trajectory under all limits but those of jerk, on a grid: TOPP-RA on the spline itself.

The solver sees s in [0, 1] and time in a unit of its own; limits are rows of fractions, computed once for the whole
grid. Its tolerances are absolute: this way everything it compares is near one, whatever the machine.
"""

from collections.abc import Callable

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.refine.result import Path
from pipeline.retime.constraints import Rows, limit_rows
from pipeline.retime.path_dynamics import PathDynamicsTable, evaluate_dynamics, grid
from pipeline.retime.quantities import limits
from pipeline.retime.result import Trajectory
from pipeline.solvers.topp_ra import SpeedProfile, fastest_profile

_GUESS_POINTS = 1_000
_MOST_CRUISING = 2.0
"""Time at the velocity limits, relative to that for starting, up to which their sum is the unit of time."""
_ADVICE = "Raise retime.grid_points, or ask for a smoother path (fewer refine.coefficients)."

Solver = Callable[[FloatArray, tuple[FloatArray, FloatArray, FloatArray], FloatArray], SpeedProfile]
"""Finds the fastest speed profile, as `fastest_profile` does."""


def plan(path: Path, grid_points: int, table: PathDynamicsTable | None = None) -> Trajectory:
    """Find the fastest trajectory along the path, from rest to rest (TOPP-RA; Pham and Pham, 2018).

    Velocity limits hold at the grid points, limits of acceleration and force at both ends of every interval; the path
    acceleration is constant in between, so that the time law s(t) is piecewise quadratic. Kinematics and dynamics are
    evaluated at the grid points, or interpolated from a table.

    Raises
    ------
    NoSolutionError
        When the planner fails; says where.
    """
    s = grid(grid_points)
    return plan_rows(path, s, limit_rows(evaluate_dynamics(path, s) if table is None else table.at(s)))


def plan_rows(path: Path, s: FloatArray, rows: Rows, solve: Solver = fastest_profile) -> Trajectory:
    """Find the fastest trajectory under limits that are known on a grid s (n,).

    Raises
    ------
    NoSolutionError
        When the planner fails; says where.
    """
    unit_s = _unit_s(path)
    scaled = (rows.a / unit_s**2, rows.b / unit_s**2, rows.c)
    profile = solve(s, scaled, rows.cap * unit_s)
    _require_profile(s, profile)
    sd, ds = profile.sd / unit_s, np.diff(s)
    return Trajectory.from_breakpoints(
        path,
        t_s=np.concatenate([[0.0], np.cumsum(2.0 * ds / (sd[1:] + sd[:-1]))]),
        s=s,
        sd=sd,
        sdd=np.append(np.diff(sd**2) / (2.0 * ds), 0.0),
    )


def _unit_s(path: Path) -> float:
    """Estimate the duration in seconds: cruising at the velocity limits, plus starting.

    Where starting takes a negligible part of a slow motion, the unit is between the two: accelerations must not come
    near the solver's tolerances either.
    """
    rates = np.abs(path.q(np.linspace(0.0, 1.0, _GUESS_POINTS), 1))
    allowed = limits(path.machine)
    cruising = (rates / allowed["velocity"]).max(axis=1).mean()
    starting = np.sqrt((rates.mean(axis=0) / allowed["acceleration"]).max())
    return float(starting + min(cruising, np.sqrt(_MOST_CRUISING * cruising * starting)))


def _require_profile(s: FloatArray, profile: SpeedProfile) -> None:
    """Raise, with the place, where there is no profile or it stops on its way."""
    if np.isnan(profile.sd).all():
        # The controllable sets are computed from the goal backwards and end with the first that is not a number.
        lost = np.flatnonzero(np.isnan(profile.controllable).any(axis=1))
        place = s[lost[0]] if lost.size else s[0]
        raise _failure("found no velocity from which the rest of the path can be driven", place, profile)
    stuck = ~np.isfinite(profile.sd)
    stuck[1:-1] |= ~(profile.sd[1:-1] > 0.0)
    if stuck.any():
        raise _failure("found no way on within the limits", s[np.argmax(stuck)], profile)


def _failure(what: str, place: float, profile: SpeedProfile) -> NoSolutionError:
    return NoSolutionError(
        "retime",
        f"the time-optimal planner {what}, at s = {place:.4f}",
        _ADVICE,
        {"s": float(place), "solver_messages": profile.messages},
    )
