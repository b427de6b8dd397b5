"""Sampling a trajectory at an exact period, from rest at the start to rest at the goal."""

import math

import numpy as np

from pipeline.arguments import require_number
from pipeline.arrays import FloatArray
from pipeline.errors import UnfitConfigError
from pipeline.machine.statics import condition_number, statics_matrix
from pipeline.retime.result import Trajectory, TrajectorySamples, stretched

MOST_ROWS = 1_000_000
"""Largest number of rows of a table: about 400 MB as CSV, and a few GB of memory while it is written."""
_SAME = 1e-9
"""Part of a period that is rounding: a duration this close above a multiple of the period counts as that multiple."""


def whole_periods(trajectory: Trajectory, period_s: float) -> Trajectory:
    """Stretch time to the next multiple of the period, so that the last sample is at the goal.

    Raises
    ------
    UnfitConfigError
        When that makes more rows than a table may have.
    """
    duration = count_periods(trajectory.duration_s, period_s) * period_s
    return trajectory if duration == trajectory.duration_s else stretched(trajectory, duration)


def count_periods(duration_s: float, period_s: float) -> int:
    """Count the periods that a duration takes, at least one.

    Raises
    ------
    UnfitConfigError
        When they make more rows than a table may have.
    """
    periods = max(1, math.ceil(duration_s / period_s - _SAME))
    if periods + 1 > MOST_ROWS:
        raise UnfitConfigError(
            "retime",
            f"retime.period_s is {period_s:g} and the trajectory takes {duration_s:,.0f} s, which makes "
            f"{periods + 1:,} rows; allowed are {MOST_ROWS:,}",
            "Raise retime.period_s (--period) or retime.speed (--speed), or shorten retime.dwell_s.",
            {"rows": periods + 1},
        )
    return periods


def sample_trajectory(trajectory: Trajectory, period_s: float) -> TrajectorySamples:
    """Sample n = ceil(T / period) periods, n + 1 rows, with time stretched by n period / T.

    Raises
    ------
    ArgumentError
        When the period is not positive.
    UnfitConfigError
        When that makes more rows than a table may have.
    ForwardKinematicsError
        Where the closure equations have no solution near the path's known poses.
    """
    period_s = require_number("period_s", period_s, above=0.0)
    trajectory = whole_periods(trajectory, period_s)
    periods = round(trajectory.duration_s / period_s)
    return sample_at(trajectory, np.arange(periods + 1, dtype=float) * period_s, period_s)


def sample_at(trajectory: Trajectory, t_s: FloatArray, period_s: float) -> TrajectorySamples:
    """Sample a trajectory at instants (n,) that are a period apart.

    Raises
    ------
    ForwardKinematicsError
        Where the closure equations have no solution near the path's known poses.
    """
    q, pose = trajectory.q(t_s), trajectory.pose(t_s)
    return TrajectorySamples(
        period_s=period_s,
        t_s=t_s,
        q_m=q,
        qd_mps=trajectory.q(t_s, 1),
        qdd_mps2=trajectory.q(t_s, 2),
        pose=pose,
        kappa=condition_number(statics_matrix(trajectory.path.machine, pose, q[:, :3])),
    )
