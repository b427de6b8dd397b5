"""From a path to a trajectory: refuse what cannot be timed, plan, limit jerk, check everywhere, fit the period."""

import math
from dataclasses import dataclass, replace

import numpy as np

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.progress import QUIET, Monitor
from pipeline.refine.result import Path
from pipeline.retime.drivable import require_motion, require_smooth
from pipeline.retime.holding_forces import require_standing
from pipeline.retime.jerk.options import DEFAULTS as JERK_DEFAULTS
from pipeline.retime.jerk.options import JerkOptions
from pipeline.retime.own_law import time_by_own_law
from pipeline.retime.path_dynamics import TABLE_POINTS, PathDynamicsTable, dynamics_table, grid
from pipeline.retime.proof.load_use import COLUMNS
from pipeline.retime.proof.motion_proof import prove_motion, require_proven
from pipeline.retime.quantities import JERK, limited
from pipeline.retime.result import TimingReport, Trajectory, slowed, stretched
from pipeline.retime.sampling import count_periods, whole_periods
from pipeline.retime.usage import ALLOWED_USAGE, Usage, measure_usage, require_limits

_GOOD_STRETCH = 1.001
"""Factor of a stretch that a finer grid need not reduce."""
_GOOD_GAP = 0.005
"""Part of the duration above its lower bound that a finer grid need not reduce."""
_GAIN = 5e-4
"""Least part of the duration that a finer grid has to gain for another one to be tried."""
_SMALL_GAIN = 2.5e-4
"""The same for a law that is not only the beginning of one with limited jerk."""


@dataclass(frozen=True)
class TimingOptions:
    """How long timing tries before it gives up; the defaults suit all tasks.

    Attributes
    ----------
    most_grid_points : int
        The grid is not doubled beyond this.
    jerk : JerkOptions
        The same for limiting jerk.
    """

    most_grid_points: int = 20_000
    jerk: JerkOptions = JERK_DEFAULTS


DEFAULTS = TimingOptions()
_NEAR = 0.9
"""Measured part of a limit of forces or of the TCP from which on it is proven, too, while time can be stretched."""
_STRETCHES = 5
"""Most times that time is stretched for a proof."""
_MOST_PIECES = 1_500
"""Largest number of pieces of such a law: of laws without jerk limits, which have thousands, it would take minutes."""


def retime_path(config: Config, path: Path, monitor: Monitor = QUIET, options: TimingOptions = DEFAULTS) -> Trajectory:
    """Time a path within all limits of the machine, from rest to rest.

    With `retime.jerk` accelerations are continuous, and zero at both ends. A path that comes with a time law keeps it,
    stretched where forces or the TCP ask for that, or gets a shorter one, with limited jerk in any case. The duration
    is a whole number of `retime.period_s`. Limits that are exceeded between the points of a program are met by
    stretching time.

    Raises
    ------
    UnfitConfigError
        When the motion has more periods than a table may have rows.
    NoSolutionError
        When the path does not move, has a corner or nearly stops, or when forces do not suffice to hold the machine.
    """
    require_smooth(path)
    require_motion(path)
    table = dynamics_table(path, max(TABLE_POINTS, config.retime.grid_points))
    require_standing(table)
    fastest = fastest_trajectory(config, table, monitor, options)
    period_s = config.retime.period_s
    start, goal = (math.ceil(wait / period_s - 1e-9) * period_s for wait in config.retime.dwell_s)
    waiting = replace(fastest, dwell_s=(start, goal))
    return fitted(config, slowed(waiting, config.retime.speed), table)


def fitted(config: Config, trajectory: Trajectory, table: PathDynamicsTable, backwards: bool = False) -> Trajectory:
    """Stretch time to whole periods, and further where a limit is exceeded at an instant that no program looked at.

    Velocity, acceleration and jerk are proven to be within their limits at every instant. Forces and the TCP's motion
    are measured between the points of every program, and proven here only if they are near a limit.

    Raises
    ------
    UnfitConfigError
        When that makes more rows than a table may have.
    NoSolutionError
        When a limit is still exceeded, or not proven to be kept; s is that along the way there, for a trajectory driven
        backwards, too.
    """
    period_s, jerk = config.retime.period_s, config.retime.jerk
    trajectory = whole_periods(trajectory, period_s)
    usage = measure_usage(trajectory, period_s, table)
    if usage.largest > ALLOWED_USAGE:
        trajectory = whole_periods(_within_limits(trajectory, usage), period_s)
        require_limits(trajectory, period_s, table, backwards)
    held = usage.held()
    near = max((float(held[name].max()) for name in COLUMNS if name in held), default=0.0) > _NEAR
    loads = near and len(trajectory.time_law.x) <= _MOST_PIECES
    # Between samples a limit may be exceeded by the thousandth part that samples are granted.
    # Where forces at rest are near their limits, the place that asks for most changes with every stretch.
    for _ in range(_STRETCHES):
        if not 1.0 < (stretch := prove_motion(trajectory, jerk=jerk, loads=loads).stretch) < math.inf:
            break
        longer = stretched(trajectory, sum(trajectory.dwell_s) + trajectory.motion_s * stretch)
        trajectory = whole_periods(longer, period_s)
    require_proven(trajectory, backwards, jerk=jerk, loads=loads)
    return trajectory


def fastest_trajectory(
    config: Config, table: PathDynamicsTable, monitor: Monitor = QUIET, options: TimingOptions = DEFAULTS
) -> Trajectory:
    """Find the fastest trajectory along the path of a table, within all limits, and report how good it is.

    Raises
    ------
    UnfitConfigError
        When the motion has more periods than a table may have rows.
    NoSolutionError
        When forces do not suffice to hold the machine.
    """
    if table.path.motion_s is not None:
        count_periods(table.path.motion_s / config.retime.speed, config.retime.period_s)
        jerk = options.jerk if _limits_jerk(config, table) else None
        return time_by_own_law(table, table.path.motion_s, config.retime.jerk_pieces, jerk, monitor)
    fastest, report = _without_jerk_limits(config, table, monitor, options)
    # The usage is measured at every tenth of a period.
    count_periods(fastest.motion_s / config.retime.speed, config.retime.period_s)
    if not _limits_jerk(config, table):
        return replace(fastest, timing=report)
    from pipeline.retime.jerk.smoothed import smoothed
    from pipeline.retime.jerk.solve import JerkLimited, limit_jerk

    try:
        found = limit_jerk(table, fastest, config.retime.jerk_pieces, monitor, options.jerk)
    except NoSolutionError:
        law = smoothed(table, fastest)
        found = JerkLimited(law, len(law.time_law.x) - 1, 0, 0)
    trajectory = _within_limits(found.trajectory, measure_usage(found.trajectory, config.retime.period_s, table))
    report = replace(
        report,
        jerk_limited=True,
        motion_s=trajectory.motion_s,
        pieces=found.pieces,
        rounds=found.rounds,
        iterations=found.iterations,
    )
    return replace(trajectory, timing=report)


def _limits_jerk(config: Config, table: PathDynamicsTable) -> bool:
    return config.retime.jerk and JERK in limited(table.path.machine)


def _without_jerk_limits(
    config: Config, table: PathDynamicsTable, monitor: Monitor, options: TimingOptions
) -> tuple[Trajectory, TimingReport]:
    """Plan without jerk limits; double the grid while limits are exceeded, or too much time is lost, between points.

    Lost time shows in the gap to the lower bound, unless a finer grid gains nothing: then the bound is too low.
    """
    # Solvers take a while to load.
    from pipeline.retime.duration_bound import duration_bound
    from pipeline.retime.fastest import plan

    limits_jerk = _limits_jerk(config, table)
    points, bound, before = config.retime.grid_points, 0.0, np.inf
    while True:
        monitor.progress(f"timing the path on {points:,} grid points")
        planned = plan(table.path, points, table)
        usage = measure_usage(planned, table=table)
        finest = 2 * points > options.most_grid_points
        if finest or (usage.largest <= ALLOWED_USAGE and usage.stretch <= _GOOD_STRETCH):
            fastest = _within_limits(planned, usage)
            if not bound:
                monitor.progress("bounding the duration from below")
                bound = duration_bound(table, grid(config.retime.bound_points))
            report = TimingReport(False, fastest.motion_s, bound, fastest.motion_s, points)
            good, gain = (report.gap <= _GOOD_GAP, _GAIN) if limits_jerk else (False, _SMALL_GAIN)
            if finest or good or fastest.motion_s > before * (1.0 - gain):
                return fastest, report
            before = fastest.motion_s
        points *= 2


def _within_limits(trajectory: Trajectory, usage: Usage) -> Trajectory:
    """Stretch time until all limits hold."""
    factor = usage.stretch
    if factor == 1.0:
        return trajectory
    return stretched(trajectory, sum(trajectory.dwell_s) + trajectory.motion_s * factor)
