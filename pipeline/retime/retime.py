"""From a path to a trajectory: refuse what cannot be timed, plan, check between the grid points, fit the period."""

import numpy as np

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.progress import Progress, silent
from pipeline.refine.result import Path
from pipeline.retime.result import Trajectory
from pipeline.retime.sampling import whole_periods
from pipeline.retime.verify import ALLOWED_USAGE, Usage, measure_usage, require_limits

_LEAST_RELATIVE_SPEED = 0.05
"""Least |q'(s)| over its mean. Where it is smaller the path velocity peaks too sharply for a law that is piecewise
constant in its derivative: on lines of known duration and 1,000 grid points, 0.02 came out up to 80 % too slow and
14 % above an acceleration limit."""
_LEAST_TRAVEL_M = 1e-9
_MOST_GRID_POINTS = 20_000
_CHECK_POINTS = 20_001
"""Values of s at which the path's speed is looked at."""


def retime_path(config: Config, path: Path, progress: Progress = silent) -> Trajectory:
    """Time a path within the machine's velocity and acceleration limits, at rest at both ends.

    The duration is a whole number of `retime.period_s`. The grid is doubled while limits are broken between its
    points; what is left then (below 0.1 %) is taken off by stretching time, so that all limits hold.

    Raises
    ------
    NoSolutionError
        When the path does not move, has a corner or comes to a stop on its way, or when the planner fails.
    """
    _require_smooth(path)
    _require_motion(path)
    planned, usage = _plan(path, config.retime.grid_points, progress)
    return whole_periods(planned, config.retime.period_s, least_s=planned.duration_s * usage.stretch)


def _plan(path: Path, points: int, progress: Progress) -> tuple[Trajectory, Usage]:
    # toppra brings a plotting library along; commands that time nothing should not wait for that.
    from pipeline.retime.plan import plan

    while True:
        progress(f"timing the path on {points:,} grid points")
        planned = plan(path, points)
        usage = measure_usage(planned)
        if usage.largest <= ALLOWED_USAGE or 2 * points > _MOST_GRID_POINTS:
            return planned, require_limits(planned)
        points *= 2


def _require_smooth(path: Path) -> None:
    """Refuse a spline whose second derivative jumps: at a corner it can only be driven by stopping."""
    degree, knots = path.spline.k, path.spline.t
    interior, counts = np.unique(knots[degree + 1 : -degree - 1], return_counts=True)
    rough = interior[degree - counts < 2]
    if rough.size:
        raise NoSolutionError(
            "retime",
            f"the path's velocity or curvature jumps at s = {rough[0]:.4f}",
            "Time a refined path: splines of degree 3 or more with simple knots.",
            {"s": float(rough[0])},
        )


def _require_motion(path: Path) -> None:
    """Refuse a path that does not move at all, or nearly stops moving with s somewhere."""
    s = np.linspace(0.0, 1.0, _CHECK_POINTS)
    if np.ptp(path.q(s), axis=0).max() < _LEAST_TRAVEL_M:
        raise NoSolutionError(
            "retime",
            "the path does not move: no actuator travels",
            "Give the task a goal that differs from its start.",
        )
    speed = np.linalg.norm(path.q(s, 1) / path.machine.velocity_mps, axis=1)
    relative = speed / speed.mean()
    slowest = int(np.argmin(relative))
    if not relative[slowest] >= _LEAST_RELATIVE_SPEED:
        raise NoSolutionError(
            "retime",
            f"the path nearly stops at s = {s[slowest]:.4f}: |q'(s)| falls to {relative[slowest]:.2%} of its mean, "
            f"and at least {_LEAST_RELATIVE_SPEED:.0%} is needed for its timing to be right",
            "Refine with other refine.coefficients or refine.corridor_cells, so that s stays close to arc length.",
            {"s": float(s[slowest]), "relative_speed": float(relative[slowest])},
        )
