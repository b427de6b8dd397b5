"""The way back: the same motion reversed in time, or, where friction makes that too slow, a motion of its own."""

from dataclasses import replace

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.progress import Progress, silent
from pipeline.retime.holding_forces import require_standing
from pipeline.retime.path_dynamics import TABLE_POINTS, TermsTable, table_of
from pipeline.retime.result import Trajectory, slowed, stretched
from pipeline.retime.retime import fastest_law
from pipeline.retime.reverse import time_reversed
from pipeline.retime.sampling import whole_periods
from pipeline.retime.usage import measure_usage, require_limits

_MOST_STRETCH = 1.01
"""Factor by which the reversed motion is slowed down at most; beyond, the way back is timed by itself."""


def way_back(config: Config, trajectory: Trajectory, progress: Progress = silent, verbose: bool = False) -> Trajectory:
    """Drive a trajectory backwards, checked by itself: without friction all forces are those of the way there.

    Where friction makes forces larger, time is stretched by up to one percent for all limits to hold. Where that does
    not suffice the way back is the fastest motion along the reversed path, at the same part of full speed.

    Raises
    ------
    NoSolutionError
        When forces do not suffice to move the machine on its way back, or a planner fails; says that it is the way
        back, and s along the way there. Or when it has more periods than a table may have rows.
    """
    try:
        return _back(config, trajectory, progress, verbose)
    except NoSolutionError as error:
        reason = f"on the way back, {error.reason}"
        raise NoSolutionError(error.stage, reason, error.advice, error.diagnosis) from error


def _back(config: Config, trajectory: Trajectory, progress: Progress, verbose: bool) -> Trajectory:
    back = time_reversed(trajectory)
    table = table_of(back.path, max(TABLE_POINTS, config.retime.grid_points))
    require_standing(table, backwards=True)
    slower = measure_usage(back, config.retime.period_s, table).stretch
    if slower > _MOST_STRETCH:
        back = _timed_by_itself(config, back, table, progress, verbose)
    else:
        back = stretched(back, sum(back.dwell_s) + back.motion_s * slower)
    back = whole_periods(back, config.retime.period_s)
    require_limits(back, config.retime.period_s, table, backwards=True)
    return back


def _timed_by_itself(
    config: Config, reversed_in_time: Trajectory, table: TermsTable, progress: Progress, verbose: bool
) -> Trajectory:
    """Find the fastest motion back, and slow it down by as much as the way there was."""
    there = reversed_in_time.quality
    try:
        law = fastest_law(config, table, progress, verbose)
    except NoSolutionError as error:
        raise NoSolutionError(
            error.stage, f"with s counted from the goal, {error.reason}", error.advice, error.diagnosis
        ) from error
    speed = 1.0 if there is None else min(1.0, there.motion_s / reversed_in_time.motion_s)
    return slowed(replace(law, dwell_s=reversed_in_time.dwell_s), speed)
