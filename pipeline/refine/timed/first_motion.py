"""A first motion along a path: its fastest time law under limits of velocity and acceleration, smoothed and fitted."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, CubicHermiteSpline
from scipy.ndimage import uniform_filter1d
from scipy.sparse import csr_array

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path
from pipeline.refine.splines import DEGREE, basis, clamped_knots
from pipeline.refine.timed.hull import RateLimit, derivative_matrix, rate_limits
from pipeline.solvers.topp_ra import fastest_profile

AT_REST = 3
"""Equal coefficients at each end: the motion begins and ends at rest, without acceleration."""
_GRID, _SAMPLES, _PASSES = 1_001, 4_097, 3
_SAMPLES_PER_COEFFICIENT = 12
_RIDGE = 1e-7
"""Weight of third differences in the fit: a coefficient between samples of standing still is not left open."""


@dataclass(frozen=True, eq=False)
class Clock:
    """When a motion is where: s of the path it began with, at tau, both (m,) from 0 to 1 and not falling."""

    tau: FloatArray
    s: FloatArray

    def s_at(self, tau: FloatArray) -> FloatArray:
        """Look up s at tau (n,). Shape (n,)."""
        return np.asarray(np.interp(tau, self.tau, self.s), dtype=float)

    def tau_at(self, s: FloatArray) -> FloatArray:
        """Look up tau at s (n,). Shape (n,)."""
        return np.asarray(np.interp(s, self.s, self.tau), dtype=float)


def first_clock(path: Path, coefficients: int) -> Clock:
    """Time a path within limits of velocity and acceleration (TOPP-RA), and average s(t) over about one knot span."""
    s = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, _GRID)))
    velocity, acceleration, _ = rate_limits(path.machine)
    a, b = _finite(path.q(s, 1), acceleration), _finite(path.q(s, 2), acceleration)
    with np.errstate(divide="ignore"):
        cap = (velocity.largest / np.abs(path.q(s, 1))).min(axis=1)
    rows = np.hstack([a, -a]), np.hstack([b, -b]), np.zeros((len(s), 2 * a.shape[1]))
    sd = fastest_profile(s, rows, cap)
    t = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / (sd[1:] + sd[:-1]))])
    dt = t[-1] / (_SAMPLES - 1)
    width = max(1, _SAMPLES // coefficients)
    reach = _PASSES * width
    inside = np.clip(dt * np.arange(-reach, _SAMPLES + reach), 0.0, t[-1])
    found = CubicHermiteSpline(t, s, sd)(inside)
    for _ in range(_PASSES):
        found = uniform_filter1d(found, width, mode="nearest")
    found = np.maximum.accumulate(np.clip(found, 0.0, 1.0))
    first, last = np.flatnonzero(found > 0.0)[0] - 1, np.flatnonzero(found < 1.0)[-1] + 2
    found = found[max(first, 0) : last]
    found[0], found[-1] = 0.0, 1.0
    return Clock(np.linspace(0.0, 1.0, len(found)), found)


def fit_motion(path: Path, clock: Clock, coefficients: int) -> BSpline:
    """Fit q(tau) to a path driven by a clock, from rest to rest."""
    knots = clamped_knots(coefficients)
    tau = np.linspace(0.0, 1.0, _SAMPLES_PER_COEFFICIENT * coefficients)
    q = path.q(clock.s_at(tau))
    c = np.zeros((coefficients, q.shape[1]))
    c[:AT_REST], c[-AT_REST:] = q[0], q[-1]
    matrix = np.vstack([_dense(basis(knots, tau)), _RIDGE * _dense(derivative_matrix(knots, DEGREE, 3))])
    wanted = np.vstack([q, np.zeros((coefficients - 3, q.shape[1]))]) - matrix @ c
    free = slice(AT_REST, -AT_REST)
    c[free] = np.linalg.lstsq(matrix[:, free], wanted, rcond=None)[0]
    return BSpline(knots, c, DEGREE)


def _finite(rates: FloatArray, limit: RateLimit) -> FloatArray:
    kept = np.isfinite(limit.largest)
    return np.asarray(rates[:, kept] / limit.largest[kept], dtype=float)


def _dense(matrix: csr_array) -> FloatArray:
    return np.asarray(matrix.toarray(), dtype=float)


def locked(machine: Machine) -> FloatArray:
    """Tell which actuators must not move at all: their velocity limit is zero. Shape (5,)."""
    return np.asarray(machine.velocity_mps == 0.0)
