"""A first guess with bounded jerk: the fastest time law, smoothed, on breakpoints where jerk will need them."""

import math

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from pipeline.arrays import BoolArray, FloatArray
from pipeline.retime.jerk.options import JerkOptions
from pipeline.retime.jerk.quartic_law import QuarticLaw
from pipeline.retime.path_dynamics import PathDynamicsTable
from pipeline.retime.quantities import JERK, evaluate, limits
from pipeline.retime.result import Trajectory

_PASSES = 3
"""Moving averages in a row: after three the path jerk is continuous, and zero at both ends."""
_WIDTHS = 2.0
"""Width of an average, in units of the time that the slowest actuator takes to build up its acceleration."""
_SAMPLES = 4_096
"""Least number of instants at which the smoothed time law is computed; more where averages are short."""
_MOST_SAMPLES = 65_536
_TAPS = 9
"""Least number of instants in an average."""
_LEAST = 1e-12
"""Least rise of s between two breakpoints."""
_MOST_CURVED = 5.0
_CHANGING = 0.2
"""Fraction of the largest jerk from which on acceleration changes quickly."""
_WHOLE = 1e-6
"""Part of a piece that is rounding."""


def first_guess(
    table: PathDynamicsTable,
    fastest: Trajectory,
    count: int,
    pieces_per_width: float = JerkOptions.pieces_per_width,
) -> QuarticLaw:
    """Smooth the fastest time law, and divide it into about `count` pieces, short where jerk needs them.

    The density of breakpoints in time is 1 + g, with g the largest fraction of a jerk limit that 3 q'' sd sdd or
    q''' sd^3 uses by itself, at most five: there the path jerk has to compensate within little time. Where acceleration
    changes quickly, at both ends and where the fastest time law switches, there are enough pieces whatever `count` is:
    in a slow motion these changes take only a small part of the time that a piece lasts elsewhere.
    """
    ramp_s = build_up_s(table)
    # A motion too short for its accelerations to build up takes a time in proportion to the cube root of its travel.
    width_s = min(_WIDTHS * ramp_s, float(np.cbrt(ramp_s * fastest.motion_s**2)))
    t, s_of_t, width_s = _smoothed(fastest, width_s)
    density, quickly = _density(table, t, s_of_t, count, width_s)
    density = np.where(quickly, np.maximum(density, pieces_per_width / width_s), density)
    passed = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) * np.diff(t) / 2.0)])
    pieces = math.ceil(passed[-1] - _WHOLE)
    return _states(s_of_t, np.interp(np.linspace(0.0, passed[-1], pieces + 1), passed, t))


def build_up_s(table: PathDynamicsTable) -> float:
    """Compute the time in which the slowest actuator builds up its acceleration under its jerk limit.

    The acceleration is what jerk allows it to reach at all: sqrt(v j) before it is at its top speed v, and
    (D j^2 / 2)^(1/3) when it travels D from rest to rest.
    """
    machine = table.path.machine
    finite = np.isfinite(machine.jerk_mps3)
    v, a, j = (limits(machine)[name][finite] for name in ("velocity", "acceleration", JERK))
    travel = np.ptp(table.path.q(table.grid.s), axis=0)[finite]
    reached = np.minimum(a, np.minimum(np.sqrt(v * j), np.cbrt(travel * j**2 / 2.0)))
    return float((reached / j).max())


def _density(
    table: PathDynamicsTable, t: FloatArray, s_of_t: BSpline, count: int, width_s: float
) -> tuple[FloatArray, BoolArray]:
    """Compute breakpoints per second at instants t (n,), `count` in all, and where acceleration changes quickly."""
    s, v, w, j = (s_of_t(t, nu=order) for order in range(4))
    dynamics, limit = table.at(s.clip(0.0, 1.0)), limits(table.path.machine)[JERK]
    bent = (np.abs(3.0 * dynamics.q2 * (v * w)[:, None]) / limit).max(axis=1)
    third = (np.abs(dynamics.q3 * (v**3)[:, None]) / limit).max(axis=1)
    density = 1.0 + np.minimum(np.maximum(bent, third), _MOST_CURVED)
    density *= count / np.trapezoid(density, t)
    jerk = (np.abs(evaluate(dynamics, v, w, j)[JERK]) / limit).max(axis=1)
    around = maximum_filter1d(jerk, 1 + 2 * round(width_s / (t[1] - t[0])))
    return density, around > _CHANGING * jerk.max()


def _smoothed(fastest: Trajectory, width_s: float) -> tuple[FloatArray, BSpline, float]:
    """Average s(t) over a width three times; returns instants (n,), s(t) as a spline, and the width used.

    The motion takes three widths longer, and reaches no larger velocities and accelerations than before, though at
    other places.
    """
    duration = fastest.motion_s
    samples = int(np.clip(_TAPS * duration / width_s, _SAMPLES, _MOST_SAMPLES))
    dt = max(duration / samples, width_s / _MOST_SAMPLES)
    taps = max(_TAPS, round(width_s / dt)) | 1
    around = dt * np.arange(1, _PASSES * taps)
    t = np.concatenate([-around[::-1], np.arange(0.0, duration, dt), duration + around])
    s = fastest.s(t + fastest.dwell_s[0])
    for _ in range(_PASSES):
        s = uniform_filter1d(s, taps, mode="nearest")
    moving = np.flatnonzero((s > _LEAST) & (s < 1.0 - _LEAST))
    s = s[moving[0] - 1 : moving[-1] + 2]
    passed = np.asarray(dt * np.arange(len(s), dtype=float))
    return passed, make_interp_spline(passed, s, k=5), dt * taps


def _states(s_of_t: BSpline, t: FloatArray) -> QuarticLaw:
    """Take the states at instants t as breakpoints; both ends are at rest, and s ascends from 0 to 1."""
    s, v, w, j = (s_of_t(t, nu=order) for order in range(4))
    s[[0, -1]] = 0.0, 1.0
    for derivative in (v, w, j):
        derivative[[0, -1]] = 0.0
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(s.clip(0.0, 1.0))) > _LEAST])
    rising[-2:] = s[-2] < 1.0 - _LEAST, True
    return QuarticLaw(s[rising], np.maximum(v, 0.0)[rising], w[rising], j[rising], np.diff(t[rising]))
