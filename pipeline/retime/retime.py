"""From a path to a trajectory: refuse what cannot be timed, plan, limit jerk, check everywhere, fit the period."""

import math
from dataclasses import replace

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.progress import Progress, silent
from pipeline.refine.result import Path
from pipeline.retime.limits import JERK, limited
from pipeline.retime.possible import require_motion, require_smooth, require_standing
from pipeline.retime.result import Quality, Trajectory, slowed, stretched
from pipeline.retime.reverse import time_reversed
from pipeline.retime.sampling import whole_periods
from pipeline.retime.terms import TABLE_POINTS, TermsTable, grid, table_of
from pipeline.retime.verify import ALLOWED_USAGE, Usage, measure_usage, require_limits

_MOST_GRID_POINTS = 20_000
_MOST_STRETCH = 1.01
"""Factor by which time is stretched at most where limits are still exceeded between the points of a program."""


def retime_path(config: Config, path: Path, progress: Progress = silent, verbose: bool = False) -> Trajectory:
    """Time a path within all limits of the machine, at rest at both ends.

    With `retime.jerk` accelerations are continuous, and zero at both ends. The duration is a whole number of
    `retime.period_s`. What limits are exceeded by between the points of a program (below 0.1 %) is taken off by
    stretching time, so that all limits hold.

    Raises
    ------
    NoSolutionError
        When the path does not move, has a corner or comes to a stop on its way, when forces do not suffice to hold the
        machine, or when a planner fails.
    """
    require_smooth(path)
    require_motion(path)
    table = table_of(path, max(TABLE_POINTS, config.retime.grid_points))
    require_standing(path, table.grid)
    law = _law(config, table, progress, verbose)
    assert law.quality is not None
    options = config.retime
    dwell = tuple(math.ceil(wait / options.period_s - 1e-9) * options.period_s for wait in options.dwell_s)
    waiting = replace(law, dwell_s=(dwell[0], dwell[1]))
    trajectory = whole_periods(slowed(waiting, options.speed), options.period_s)
    require_limits(trajectory, options.period_s, table)
    return trajectory


def way_back(config: Config, trajectory: Trajectory) -> Trajectory:
    """Drive a trajectory backwards, checked by itself; where friction makes forces larger, as much slower as needed.

    Raises
    ------
    NoSolutionError
        When forces do not suffice to hold the machine on its way back.
    """
    back = time_reversed(trajectory)
    table = table_of(back.path, TABLE_POINTS)
    require_standing(back.path, table.grid)
    slower = measure_usage(back, config.retime.period_s, table).stretch
    back = stretched(back, sum(back.dwell_s) + back.motion_s * slower)
    back = whole_periods(back, config.retime.period_s)
    require_limits(back, config.retime.period_s, table)
    return back


def _law(config: Config, table: TermsTable, progress: Progress, verbose: bool) -> Trajectory:
    """Find the time law itself."""
    # Solvers, and a plotting library that one of them brings along, take a while to load.
    from pipeline.retime.bound import duration_bound

    options = config.retime
    fastest, usage, points = _fastest(table, options.grid_points, progress)
    progress("bounding the duration from below")
    bound = duration_bound(table, grid(options.bound_points))
    limit_jerk = options.jerk and JERK in limited(table.path.machine)
    quality = Quality(limit_jerk, fastest.motion_s, bound, fastest.motion_s, points)
    if not limit_jerk:
        return replace(_within_limits(fastest, usage), quality=quality)
    from pipeline.retime.jerk import limit_jerk as with_limited_jerk

    found = with_limited_jerk(table, fastest, options.jerk_pieces, progress, verbose)
    law = _within_limits(found.trajectory, measure_usage(found.trajectory, options.period_s, table))
    return replace(
        law,
        quality=replace(
            quality,
            motion_s=law.motion_s,
            pieces=found.pieces,
            rounds=found.rounds,
            iterations=found.iterations,
        ),
    )


def _fastest(table: TermsTable, points: int, progress: Progress) -> tuple[Trajectory, Usage, int]:
    """Plan without jerk limits; the grid is doubled while limits are broken between its points."""
    from pipeline.retime.plan import plan_rows
    from pipeline.retime.rows import limit_rows

    while True:
        progress(f"timing the path on {points:,} grid points")
        s = grid(points)
        planned = plan_rows(table.path, s, limit_rows(table.at(s)))
        usage = measure_usage(planned, table=table)
        if usage.largest <= ALLOWED_USAGE:
            return planned, usage, points
        if 2 * points > _MOST_GRID_POINTS:
            return planned, require_limits(planned, table=table), points
        points *= 2


def _within_limits(trajectory: Trajectory, usage: Usage) -> Trajectory:
    """Stretch time by what a usage asks for, for nothing to be above its limit.

    Raises
    ------
    NoSolutionError
        When that is too much to be called rounding.
    """
    factor = usage.stretch
    if factor == 1.0:
        return trajectory
    if factor > _MOST_STRETCH:
        raise NoSolutionError(
            "retime",
            f"limits are exceeded between the points of the program: time would have to be stretched by "
            f"{factor - 1.0:.2%}",
            "Give more retime.jerk_pieces, or ask for a smoother path (fewer refine.coefficients).",
            {"stretch": factor},
        )
    return stretched(trajectory, sum(trajectory.dwell_s) + trajectory.motion_s * factor)
