"""The way back: the same motion reversed in time, or a motion of its own where friction makes that too slow."""

from dataclasses import replace
from math import comb

import numpy as np
from scipy.interpolate import BSpline, PPoly

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.progress import QUIET, Monitor
from pipeline.refine.result import Path
from pipeline.retime.holding_forces import require_standing
from pipeline.retime.path_dynamics import TABLE_POINTS, PathDynamicsTable, dynamics_table
from pipeline.retime.result import Trajectory, slowed, stretched
from pipeline.retime.retime import fastest_trajectory, fitted
from pipeline.retime.usage import measure_usage

_MOST_STRETCH = 1.01
"""Largest factor by which the reversed motion is slowed down; beyond it, the way back is timed by itself."""


def way_back(config: Config, trajectory: Trajectory, monitor: Monitor = QUIET) -> Trajectory:
    """Drive a trajectory backwards, with a check of its own: only without friction are forces the same both ways.

    Where friction makes forces larger, time is stretched by up to one percent for all limits to hold. Where that does
    not suffice, the way back is the fastest motion along the reversed path, at the same fraction of full speed.

    Raises
    ------
    NoSolutionError
        When forces do not suffice to move the machine on its way back; says that it is the way back, and reports s
        along the way there.
    UnfitConfigError
        When the motion has more periods than a table may have rows.
    """
    try:
        return _back(config, trajectory, monitor)
    except NoSolutionError as error:
        reason = f"on the way back, {error.reason}"
        raise NoSolutionError(error.stage, reason, error.advice, error.diagnosis) from error


def _back(config: Config, trajectory: Trajectory, monitor: Monitor) -> Trajectory:
    back = time_reversed(trajectory)
    table = dynamics_table(back.path, max(TABLE_POINTS, config.retime.grid_points))
    require_standing(table, backwards=True)
    stretch = measure_usage(back, config.retime.period_s, table).stretch
    if stretch > _MOST_STRETCH:
        back = _timed_by_itself(config, back, table, monitor)
    else:
        back = stretched(back, sum(back.dwell_s) + back.motion_s * stretch)
    return fitted(config, back, table, backwards=True)


def _timed_by_itself(
    config: Config, reversed_in_time: Trajectory, table: PathDynamicsTable, monitor: Monitor
) -> Trajectory:
    """Find the fastest motion back, and slow it down by as much as the way there was."""
    there = reversed_in_time.timing
    try:
        fastest = fastest_trajectory(config, table, monitor)
    except NoSolutionError as error:
        raise NoSolutionError(
            error.stage, f"with s counted from the goal, {error.reason}", error.advice, error.diagnosis
        ) from error
    speed = 1.0 if there is None else min(1.0, there.motion_s / reversed_in_time.motion_s)
    return slowed(replace(fastest, dwell_s=reversed_in_time.dwell_s), speed)


def reversed_path(path: Path) -> Path:
    """Reverse a curve: q(1 - s)."""
    knots, coefficients, degree = path.spline.tck
    spline = BSpline(1.0 - knots[::-1], coefficients[::-1], degree)
    return replace(path, spline=spline, node_s=1.0 - path.node_s[::-1], node_pose=path.node_pose[::-1])


def time_reversed(trajectory: Trajectory) -> Trajectory:
    """Reverse a trajectory in time: s_back(t) = 1 - s(T - t), with the waiting times exchanged.

    A piece p(e), 0 <= e <= h, becomes 1 - p(h - e): its coefficient of e^k is -(-1)^k p^(k)(h) / k!. Velocities change
    their sign; accelerations stay the same, and so do forces except friction.
    """
    time_law = trajectory.time_law
    degree, h = len(time_law.c) - 1, np.diff(time_law.x)
    rows = []
    for k in range(degree, -1, -1):
        powers = range(k, degree + 1)
        at_end = sum(comb(p, k) * time_law.c[degree - p] * h ** (p - k) for p in powers)
        rows.append(-((-1.0) ** k) * at_end[::-1])
    rows[-1] = 1.0 + rows[-1]
    t = time_law.x[-1] - time_law.x[::-1]
    t[-1] = time_law.x[-1]
    return replace(
        trajectory,
        path=reversed_path(trajectory.path),
        time_law=PPoly(np.stack(rows), t),
        dwell_s=trajectory.dwell_s[::-1],
    )
