"""From a path to a trajectory: refuse what cannot be timed, plan, limit jerk, check everywhere, fit the period."""

import math
from dataclasses import replace

import numpy as np

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.progress import Progress, silent
from pipeline.refine.result import Path
from pipeline.retime.drivable import require_motion, require_smooth
from pipeline.retime.holding_forces import require_standing
from pipeline.retime.path_dynamics import TABLE_POINTS, TermsTable, grid, table_of
from pipeline.retime.quantities import JERK, limited
from pipeline.retime.result import Quality, Trajectory, slowed, stretched
from pipeline.retime.sampling import count_periods, whole_periods
from pipeline.retime.usage import ALLOWED_USAGE, Usage, measure_usage, require_limits

_MOST_GRID_POINTS = 20_000
_MOST_USAGE = 1.01
"""Largest fraction of a limit, between the points of a program, that stretching time may take off."""
_GOOD_STRETCH = 1.001
"""Factor of such a stretch that a finer grid need not make smaller."""
_GOOD_GAP = 0.005
"""Part of the duration above its lower bound that a finer grid need not make smaller."""
_GAIN = 5e-4
"""Part of the duration that a finer grid has to gain for another one to be tried."""


def retime_path(config: Config, path: Path, progress: Progress = silent, verbose: bool = False) -> Trajectory:
    """Time a path within all limits of the machine, at rest at both ends.

    With `retime.jerk` accelerations are continuous, and zero at both ends. The duration is a whole number of
    `retime.period_s`. What limits are exceeded by between the points of a program is taken off by stretching time, so
    that all limits hold.

    Raises
    ------
    UnfitConfigError
        When the motion has more periods than a table may have rows.
    NoSolutionError
        When the path does not move, has a corner or comes to a stop on its way, when forces do not suffice to hold the
        machine, or when a planner fails.
    """
    require_smooth(path)
    require_motion(path)
    table = table_of(path, max(TABLE_POINTS, config.retime.grid_points))
    require_standing(table)
    law = fastest_law(config, table, progress, verbose)
    options = config.retime
    dwell = tuple(math.ceil(wait / options.period_s - 1e-9) * options.period_s for wait in options.dwell_s)
    waiting = replace(law, dwell_s=(dwell[0], dwell[1]))
    trajectory = whole_periods(slowed(waiting, options.speed), options.period_s)
    require_limits(trajectory, options.period_s, table)
    return trajectory


def fastest_law(config: Config, table: TermsTable, progress: Progress, verbose: bool) -> Trajectory:
    """Find the fastest time law along the path of a table, within all limits, and how good it is.

    Raises
    ------
    UnfitConfigError
        When the motion has more periods than a table may have rows.
    NoSolutionError
        When a planner fails, or leaves limits exceeded between its points by more than a percent.
    """
    options = config.retime
    fastest = _fastest(config, table, progress)
    # What follows looks at every tenth of a period.
    count_periods(fastest.motion_s / options.speed, options.period_s)
    limit_jerk = options.jerk and JERK in limited(table.path.machine)
    if not limit_jerk:
        return fastest
    assert fastest.quality is not None
    from pipeline.retime.jerk.solve import limit_jerk as with_limited_jerk

    found = with_limited_jerk(table, fastest, options.jerk_pieces, progress, verbose)
    usage = measure_usage(found.trajectory, options.period_s, table)
    law = _within_limits(found.trajectory, usage, table, "Give more retime.jerk_pieces")
    return replace(
        law,
        quality=replace(
            fastest.quality,
            jerk_limited=True,
            motion_s=law.motion_s,
            pieces=found.pieces,
            rounds=found.rounds,
            iterations=found.iterations,
        ),
    )


def _fastest(config: Config, table: TermsTable, progress: Progress) -> Trajectory:
    """Plan without jerk limits; the grid is doubled while limits are broken, or too much time is lost, between points.

    Time lost shows in the gap to the lower bound, unless a finer grid does not gain any: then the bound is too low.
    """
    # Solvers, and a plotting library that one of them brings along, take a while to load.
    from pipeline.retime.duration_bound import duration_bound
    from pipeline.retime.toppra import plan

    points, bound, before = config.retime.grid_points, 0.0, np.inf
    while True:
        progress(f"timing the path on {points:,} grid points")
        planned = plan(table.path, points, table)
        usage = measure_usage(planned, table=table)
        finest = 2 * points > _MOST_GRID_POINTS
        if finest or (usage.largest <= ALLOWED_USAGE and usage.stretch <= _GOOD_STRETCH):
            law = _within_limits(planned, usage, table, "Raise retime.grid_points")
            if not bound:
                progress("bounding the duration from below")
                bound = duration_bound(table, grid(config.retime.bound_points))
            quality = Quality(False, law.motion_s, bound, law.motion_s, points)
            if finest or quality.gap <= _GOOD_GAP or law.motion_s > before * (1.0 - _GAIN):
                return replace(law, quality=quality)
            before = law.motion_s
        points *= 2


def _within_limits(trajectory: Trajectory, usage: Usage, table: TermsTable, advice: str) -> Trajectory:
    """Stretch time by what a usage asks for, for nothing to be above its limit.

    Raises
    ------
    NoSolutionError
        When a limit is exceeded by more than what can be called rounding; names it and the place.
    """
    if usage.largest > _MOST_USAGE:
        try:
            require_limits(trajectory, table=table)
        except NoSolutionError as error:
            advice = f"{advice}, or ask for a smoother path (fewer refine.coefficients)."
            raise NoSolutionError(error.stage, error.reason, advice, error.diagnosis) from None
    factor = usage.stretch
    return (
        trajectory if factor == 1.0 else stretched(trajectory, sum(trajectory.dwell_s) + trajectory.motion_s * factor)
    )
