"""A first guess with bounded jerk: the fastest time law, smoothed, on breakpoints where jerk will need them."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from pipeline.arrays import BoolArray, FloatArray
from pipeline.retime.jerk.options import JerkOptions
from pipeline.retime.jerk.quartic_law import QuarticLaw
from pipeline.retime.path_dynamics import PathDynamicsTable
from pipeline.retime.quantities import JERK, evaluate, limits
from pipeline.retime.result import Trajectory, stretched

_PASSES = 3
"""Moving averages in a row: after three the path jerk is continuous, and zero at both ends."""
_WIDTHS = 2.0
"""Width of an average, in units of the time that the slowest actuator takes to build up its acceleration."""
_SAMPLES = 4_096
"""Least number of instants at which the smoothed time law is computed; more where averages are short."""
_MOST_SAMPLES = 65_536
_TAPS = 9
"""Least number of instants in an average."""
_MOST_JERK, _GOOD_JERK = 12.0, 4.0
"""Fraction of a jerk limit above which a smoothed law is begun anew from a slower one, and the fraction aimed at."""
_SLOWDOWNS = 12
"""Slower laws tried at most."""
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
    smooth = smooth_law(table, fastest)
    density, quickly = _density(table, smooth, count)
    density = np.where(quickly, np.maximum(density, pieces_per_width / smooth.width_s), density)
    passed = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) * np.diff(smooth.t_s) / 2.0)])
    pieces = math.ceil(passed[-1] - _WHOLE)
    return _states(smooth.s_of_t, np.interp(np.linspace(0.0, passed[-1], pieces + 1), passed, smooth.t_s))


@dataclass(frozen=True, eq=False)
class SmoothLaw:
    """A smoothed time law: instants (n,), s(t), the width of its averages, and the law that was smoothed."""

    t_s: FloatArray
    s_of_t: BSpline
    width_s: float
    begun: Trajectory


def smooth_law(table: PathDynamicsTable, fastest: Trajectory) -> SmoothLaw:
    """Smooth the fastest time law, first slowed down where jerk limits are too low for its speed.

    The jerk that the curvature of the path causes falls with the third power of the time, whatever the averages.
    """
    begun = fastest
    for _ in range(_SLOWDOWNS):
        ramp_s = build_up_s(table, begun.motion_s / fastest.motion_s)
        # A motion too short for its accelerations to build up takes a time that grows as the cube root of its travel.
        width_s = min(_WIDTHS * ramp_s, float(np.cbrt(ramp_s * begun.motion_s**2)))
        smooth = SmoothLaw(*_smoothed(begun, width_s), begun)
        most = _jerks(table, smooth)[1].max()
        if most <= _MOST_JERK:
            break
        begun = stretched(begun, sum(begun.dwell_s) + begun.motion_s * float(np.cbrt(most / _GOOD_JERK)))
    return smooth


def build_up_s(table: PathDynamicsTable, slowdown: float = 1.0) -> float:
    """Compute the time in which the slowest actuator builds up its acceleration under its jerk limit.

    The acceleration is what jerk allows it to reach at all: sqrt(v j) before it is at its top speed v, and
    (D j^2 / 2)^(1/3) when it travels D from rest to rest. On a clock that is slower by f, v and the limit of
    acceleration are less by f and f^2.
    """
    machine = table.path.machine
    finite = np.isfinite(machine.jerk_mps3)
    v, a, j = (limits(machine)[name][finite] for name in ("velocity", "acceleration", JERK))
    travel = np.ptp(table.path.q(table.grid.s), axis=0)[finite]
    reached = np.minimum(a / slowdown**2, np.minimum(np.sqrt(v / slowdown * j), np.cbrt(travel * j**2 / 2.0)))
    return float((reached / j).max())


def _jerks(table: PathDynamicsTable, smooth: SmoothLaw) -> tuple[FloatArray, FloatArray]:
    """Compute the largest fraction of a jerk limit, by the curvature of the path alone and in all. Shapes (n,)."""
    s, v, w, j = (smooth.s_of_t(smooth.t_s, nu=order) for order in range(4))
    dynamics, limit = table.at(s.clip(0.0, 1.0)), limits(table.path.machine)[JERK]
    bent = (np.abs(3.0 * dynamics.q2 * (v * w)[:, None]) / limit).max(axis=1)
    third = (np.abs(dynamics.q3 * (v**3)[:, None]) / limit).max(axis=1)
    whole = (np.abs(evaluate(dynamics, v, w, j)[JERK]) / limit).max(axis=1)
    return np.maximum(bent, third), whole


def _density(table: PathDynamicsTable, smooth: SmoothLaw, count: int) -> tuple[FloatArray, BoolArray]:
    """Compute breakpoints per second at instants (n,), `count` in all, and where acceleration changes quickly."""
    curved, jerk = _jerks(table, smooth)
    density = 1.0 + np.minimum(curved, _MOST_CURVED)
    density *= count / np.trapezoid(density, smooth.t_s)
    around = maximum_filter1d(jerk, 1 + 2 * round(smooth.width_s / (smooth.t_s[1] - smooth.t_s[0])))
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
