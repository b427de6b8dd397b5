"""Paths that come with a time law of their own (`Path.motion_s`): taken as it is, or shortened where that is possible.

Such a path begins and ends at rest in its own parameter: q' = q'' = 0 there, which no planner over s takes. Its time
law s = t / T keeps velocity, acceleration and, unless `retime.jerk` is off, jerk at every instant. Where forces or the
TCP exceed a limit, time is stretched. From there the program of limited jerk shortens the motion under all limits; sd
is free at both ends.
"""

from dataclasses import replace

import numpy as np
from scipy.interpolate import PPoly

from pipeline.errors import NoSolutionError
from pipeline.progress import QUIET, Monitor
from pipeline.refine.result import Path
from pipeline.retime.jerk.options import JerkOptions
from pipeline.retime.path_dynamics import PathDynamicsTable
from pipeline.retime.result import TimingReport, Trajectory, stretched
from pipeline.retime.usage import measure_usage

_WORTH = 1e-4
"""Least part of the duration that another time law has to gain to replace the path's own."""


def own_time_law(path: Path, motion_s: float, limits_jerk: bool = True) -> Trajectory:
    """Drive a path at s = t / T, with a piece of the time law for every knot span.

    Of degree four, with zeros, or without jerk limits of degree two, as other time laws are.
    """
    knots = np.unique(path.spline.t)
    none = np.zeros(len(knots) - 1)
    rates = np.stack([none, none, none, np.full(len(knots) - 1, 1.0 / motion_s), knots[:-1]])
    return Trajectory(path, PPoly(rates if limits_jerk else rates[2:], motion_s * knots))


def time_by_own_law(
    table: PathDynamicsTable,
    motion_s: float,
    pieces: int,
    options: JerkOptions | None,
    monitor: Monitor = QUIET,
) -> Trajectory:
    """Take the time law of a path, which lasts `motion_s`, or a shorter one under all limits, and report which.

    Without `options` jerk is not limited, and the time law stays: no planner beside that of limited jerk can begin it.

    Raises
    ------
    NoSolutionError
        When forces do not suffice to hold the machine.
    """
    own = _within_limits(own_time_law(table.path, motion_s, options is not None), table)
    report = TimingReport(options is not None, np.nan, np.nan, own.motion_s, 0)
    if options is None:
        return replace(own, timing=report)
    from pipeline.retime.jerk.solve import shorten

    try:
        found = shorten(table, own, pieces, monitor, options)
    except NoSolutionError:
        return replace(own, timing=report)
    shorter = _within_limits(found.trajectory, table)
    if shorter.motion_s > own.motion_s * (1.0 - _WORTH):
        return replace(own, timing=report)
    report = TimingReport(True, np.nan, np.nan, shorter.motion_s, 0, found.pieces, found.rounds, found.iterations)
    return replace(shorter, timing=report)


def _within_limits(trajectory: Trajectory, table: PathDynamicsTable) -> Trajectory:
    return stretched(trajectory, trajectory.motion_s * measure_usage(trajectory, table=table).stretch)
