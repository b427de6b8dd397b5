"""A first guess with bounded jerk: the fastest law, blurred in time, on breakpoints where jerk will need them."""

import math

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from pipeline.arrays import FloatArray
from pipeline.retime.jerk.law import Pieces
from pipeline.retime.path_dynamics import TermsTable
from pipeline.retime.quantities import limits
from pipeline.retime.result import Trajectory

_PASSES = 3
"""Moving averages in a row: after three the path jerk is continuous, and zero at both ends."""
_WIDTHS = 2.0
"""Width of an average in the time that the slowest actuator takes to build up its acceleration."""
_SAMPLES = 4_096
"""Instants at which the blurred law is computed, at least; where averages are short, more."""
_MOST_SAMPLES = 65_536
_TAPS = 9
"""Instants that an average is taken over, at least."""
_LEAST = 1e-12
"""Least rise of s between two breakpoints."""
_MOST_CURVED = 5.0
_PER_WIDTH = 3.0
"""Pieces within the width of an average where acceleration changes, at least."""
_CHANGING = 0.2
"""Part of the law's largest jerk from which on acceleration changes quickly."""
_WHOLE = 1e-6
"""Part of a piece that is rounding."""


def first_guess(table: TermsTable, fastest: Trajectory, count: int) -> Pieces:
    """Blur the fastest law, and lay about `count` pieces where time passes and where jerk needs them.

    The density of breakpoints in time is 1 + g, with g the largest fraction of a jerk limit that 3 q'' sd sdd or
    q''' sd^3 makes by itself, cut off at five: there the path jerk has to compensate within little time. Where
    acceleration changes quickly, at both ends and where the fastest law switches, there are pieces enough whatever
    `count` is: in a slow motion it does so within a small part of the time that one piece lasts elsewhere.
    """
    machine = table.path.machine
    finite = np.isfinite(machine.jerk_mps3)
    ramp_s = float((machine.acceleration_mps2[finite] / machine.jerk_mps3[finite]).max())
    # A motion too short for its accelerations to build up takes about the cube root of what jerk makes of it.
    width_s = min(_WIDTHS * ramp_s, float(np.cbrt(ramp_s * fastest.motion_s**2)))
    t, law, width_s = _blurred(fastest, width_s)
    density = _density(table, t, law, count, width_s)
    passed = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) * np.diff(t) / 2.0)])
    pieces = math.ceil(passed[-1] - _WHOLE)
    return _pieces(law, np.interp(np.linspace(0.0, passed[-1], pieces + 1), passed, t))


def _density(table: TermsTable, t: FloatArray, law: BSpline, count: int, width_s: float) -> FloatArray:
    """Breakpoints per second at instants t (n,): `count` in all, and more within a width of quick changes."""
    s, v, w, j = (law(t, nu=order) for order in range(4))
    terms, limit = table.at(s.clip(0.0, 1.0)), limits(table.path.machine)["jerk"]
    bent = (np.abs(3.0 * terms.q2 * (v * w)[:, None]) / limit).max(axis=1)
    third = (np.abs(terms.q3 * (v**3)[:, None]) / limit).max(axis=1)
    density = 1.0 + np.minimum(np.maximum(bent, third), _MOST_CURVED)
    density *= count / np.trapezoid(density, t)
    jerk = (np.abs(terms.values(v, w, j)["jerk"]) / limit).max(axis=1)
    around = maximum_filter1d(jerk, 1 + 2 * round(width_s / (t[1] - t[0])))
    quickly = around > _CHANGING * jerk.max()
    found: FloatArray = np.where(quickly, np.maximum(density, _PER_WIDTH / width_s), density)
    return found


def _blurred(fastest: Trajectory, width_s: float) -> tuple[FloatArray, BSpline, float]:
    """Average s(t) over a width three times; instants (n,), the law as a spline, and the width that came of it.

    The motion lasts three widths longer, and reaches velocities and accelerations no larger than before, though at
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
    passed: FloatArray = dt * np.arange(len(s), dtype=float)
    return passed, make_interp_spline(passed, s, k=5), dt * taps


def _pieces(law: BSpline, t: FloatArray) -> Pieces:
    """Take the law's state at instants t; at both ends nothing moves, and s ascends from 0 to 1."""
    s, v, w, j = (law(t, nu=order) for order in range(4))
    s[[0, -1]] = 0.0, 1.0
    for derivative in (v, w, j):
        derivative[[0, -1]] = 0.0
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(s.clip(0.0, 1.0))) > _LEAST])
    rising[-2:] = s[-2] < 1.0 - _LEAST, True
    return Pieces(s[rising], np.maximum(v, 0.0)[rising], w[rising], j[rising], np.diff(t[rising]))
