"""Timings without an optimal planner: profiles with constant limits along the path, and Ruckig from stop to stop.

Ruckig's free version plans from one state to another; passing through waypoints without stopping is not part of it.
"""

import itertools
from collections.abc import Callable

import numpy as np
from scipy.interpolate import BSpline, PchipInterpolator

from pipeline.refine.result import Path
from pipeline.refine.splines import clamped_knots, fit

_FINE = 8_001
_COEFFICIENTS = 400
_TRIALS = 60
_NORM = 8


def trapezoid(path: Path, _: np.ndarray) -> float:
    """The shortest trapezoidal profile whose constant limits hold everywhere: no limit of jerk."""
    first, second, _third = _even(path)
    machine = path.machine

    def duration(v: float) -> float:
        room = machine.acceleration_mps2 - np.abs(second) * v**2
        a = (room / np.abs(first).clip(1e-12)).min()
        return _profile(v, a, np.inf) if a > 0.0 else np.inf

    return min(duration(v) for v in _speeds(first, machine.velocity_mps))


def s_curve(path: Path, _: np.ndarray) -> float:
    """The shortest seven-segment profile whose constant limits hold everywhere, jerk included."""
    first, second, third = (np.abs(part) for part in _even(path))
    machine = path.machine
    best = np.inf
    for v, share in itertools.product(_speeds(first, machine.velocity_mps), np.linspace(0.05, 1.0, 20)):
        room = machine.acceleration_mps2 - second * v**2
        a = share * float((room / first.clip(1e-12)).min())
        if a <= 0.0:
            continue
        j = ((machine.jerk_mps3 - 3.0 * second * v * a - third * v**3) / first.clip(1e-12)).min()
        if j > 0.0:
            best = min(best, _profile(v, a, float(j)))
    return best


def ruckig_stops(path: Path, waypoints: np.ndarray) -> float:
    """From step to step of the route with Ruckig, in phase along straight lines, at rest at every step."""
    import ruckig

    machine = path.machine
    planner, total = ruckig.Ruckig(5), 0.0
    for begin, end in itertools.pairwise(waypoints.tolist()):
        motion = ruckig.InputParameter(5)
        motion.current_position, motion.target_position = begin, end
        motion.max_velocity = machine.velocity_mps.tolist()
        motion.max_acceleration = machine.acceleration_mps2.tolist()
        motion.max_jerk = machine.jerk_mps3.tolist()
        motion.synchronization = ruckig.Synchronization.Phase
        trajectory = ruckig.Trajectory(5)
        if planner.calculate(motion, trajectory) < 0:
            raise ArithmeticError(f"no motion from {begin} to {end}")
        total += trajectory.duration
    return total


ALTERNATIVES: tuple[tuple[str, Callable[[Path, np.ndarray], float]], ...] = (
    ("trapezoidal profile along the path (no jerk limit)", trapezoid),
    ("seven-segment profile along the path", s_curve),
    ("Ruckig from step to step of the route, stopping at each", ruckig_stops),
)


def _even(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First three derivatives of q by a parameter from 0 to 1 along which velocity limits are about even."""
    s = np.linspace(0.0, 1.0, _FINE)
    effort = np.linalg.norm(path.q(s, 1) / path.machine.velocity_mps, ord=_NORM, axis=1)
    passed = np.concatenate([[0.0], np.cumsum((effort[1:] + effort[:-1]) / 2.0)])
    places = PchipInterpolator(passed / passed[-1], s)(s)
    knots = clamped_knots(_COEFFICIENTS)
    spline = BSpline(knots, fit(knots, s, path.q(places)), 5)
    first, second, third = (spline(s, nu=order) for order in (1, 2, 3))
    return first, second, third


def _speeds(first: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    top = (velocity / np.abs(first).max(axis=0).clip(1e-12)).min()
    return top * np.linspace(0.02, 1.0, _TRIALS)


def _profile(v: float, a: float, j: float) -> float:
    """Seconds from rest to rest over a unit of length under constant limits."""
    if v**2 / a + v * a / j <= 1.0:
        return 1.0 / v + v / a + a / j
    if 2.0 * a**3 / j**2 <= 1.0:
        return a / j + float(np.sqrt((a / j) ** 2 + 4.0 / a))
    return 4.0 * float(np.cbrt(0.5 / j))
