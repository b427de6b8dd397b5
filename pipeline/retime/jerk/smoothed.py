"""A motion with bounded jerk along every path: the fastest time law, smoothed, and slowed down until all limits hold.

A uniform spline of degree four whose control points are values of the fastest s(t) rises as it does, with no larger
path speeds and accelerations; its jerk is continuous, and zero at both ends. It is the last resort where a program does
not converge: no other limit than that of forces at rest can prevent it.
"""

import math

import numpy as np
from scipy.interpolate import BSpline, PPoly

from pipeline.retime.jerk.first_guess import smooth_law
from pipeline.retime.path_dynamics import PathDynamicsTable
from pipeline.retime.result import Trajectory, stretched
from pipeline.retime.usage import measure_usage

_DEGREE = 4
_MOST_POINTS = 5_000
"""Most values of s(t) that are smoothed: what the shape of the fastest law needs."""
_WIDTHS = (1.0, 4.0)
"""Steps between control points that are tried, in units of the width that a first guess is averaged over."""


def smoothed(table: PathDynamicsTable, fastest: Trajectory) -> Trajectory:
    """Smooth a time law over about the time in which accelerations build up, and slow it down to keep all limits."""
    smooth = smooth_law(table, fastest)
    tried = [_smoothed(smooth.begun, factor * smooth.width_s) for factor in _WIDTHS]
    kept = [stretched(law, law.motion_s * measure_usage(law, table=table).stretch) for law in tried]
    return min(kept, key=lambda law: law.motion_s)


def _smoothed(fastest: Trajectory, step_s: float) -> Trajectory:
    duration = fastest.motion_s
    count = min(max(1, math.ceil(duration / step_s)), _MOST_POINTS)
    step_s = max(step_s, duration / count)
    inner = fastest.s(np.asarray(fastest.dwell_s[0] + duration / count * (np.arange(count) + 0.5), dtype=float))
    values = np.concatenate([np.zeros(_DEGREE), np.maximum.accumulate(inner), np.ones(_DEGREE)])
    knots = step_s * np.arange(-_DEGREE, len(values) + 1.0)
    whole = PPoly.from_spline(BSpline(knots, values, _DEGREE))
    pieces = slice(_DEGREE, len(values))
    return Trajectory(fastest.path, PPoly(whole.c[:, pieces], whole.x[_DEGREE : len(values) + 1]))
