"""Motions with known answers: from rest to rest along a line by s(t) = 10 u^3 - 15 u^4 + 6 u^5 with u = t / T."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import BSpline, PPoly

from pipeline.refine.result import Path
from pipeline.retime import Trajectory

DURATION_S = 4.0
PEAKS = np.array([15.0 / 8.0 / DURATION_S, 10.0 / np.sqrt(3.0) / DURATION_S**2, 60.0 / DURATION_S**3])
"""Largest |s'|, |s''|, |s'''|."""


def at_rest_at_both_ends(path: Path, duration_s: float = DURATION_S) -> Trajectory:
    """Drive a path by the quintic."""
    quintic = [part / duration_s**power for part, power in ((6.0, 5), (-15.0, 4), (10.0, 3))]
    return Trajectory(path, PPoly(np.array([*quintic, 0.0, 0.0, 0.0])[:, None], [0.0, duration_s]))


def of_degree_two(trajectory: Trajectory, duration_s: float) -> Trajectory:
    """Drive a path at constant path acceleration up to its middle, and as much the other way from there."""
    half = duration_s / 2.0
    curve = 0.5 / half**2
    law = PPoly(np.array([[curve, -curve], [0.0, 2.0 * curve * half], [0.0, 0.5]]), [0.0, half, duration_s])
    return replace(trajectory, time_law=law)


def with_bump(trajectory: Trajectory, at_s: float, width_s: float, height: float) -> Trajectory:
    """Add a bump h (4 u (w - u) / w^2)^3 to s(t) for a while: position, velocity and acceleration stay continuous."""
    law = trajectory.time_law
    breaks = np.array([0.0, at_s, at_s + width_s, law.x[-1]])
    parts = [np.polynomial.Polynomial(law.c[::-1, 0])(np.polynomial.Polynomial([begins, 1.0])) for begins in breaks[:3]]
    bump = np.polynomial.Polynomial([0.0, 4.0 / width_s, -4.0 / width_s**2])
    parts[1] = parts[1] + height * bump**3
    rows = [np.pad(part.coef, (0, 7 - len(part.coef)))[::-1] for part in parts]
    return replace(trajectory, time_law=PPoly(np.array(rows).T, breaks))


def with_corner(trajectory: Trajectory, multiplicity: int) -> Trajectory:
    """Drive from the same start to the same goal by way of a corner at s = 0.5, slowly; straight on either side."""
    path, degree = trajectory.path, 5
    knots = np.concatenate([np.zeros(degree + 1), np.full(multiplicity, 0.5), np.ones(degree + 1)])
    # Coefficients at the means of knots make straight lines.
    along = np.array([knots[n + 1 : n + 1 + degree].mean() for n in range(degree + 1 + multiplicity)])[:, None]
    aside = 0.02 * (0.5 - np.abs(along - 0.5)) * np.array([1.0, 0.0, 0.0, 0.0, 0.0])
    spline = BSpline(knots, path.q(0.0) + (path.q(1.0) - path.q(0.0)) * along + aside, degree)
    return at_rest_at_both_ends(replace(path, spline=spline), 40.0)


def with_locked(trajectory: Trajectory, actuator: int) -> Trajectory:
    """Lock an actuator of the machine, whatever the path asks of it."""
    machine = trajectory.path.machine
    velocity = np.where(np.arange(5) == actuator, 0.0, machine.velocity_mps)
    return replace(trajectory, path=replace(trajectory.path, machine=replace(machine, velocity_mps=velocity)))


def limited_to(path: Path, velocity: float, acceleration: float, jerk: float) -> Path:
    """Give all actuators of a path's machine the same limits."""
    machine = replace(
        path.machine,
        velocity_mps=np.full(5, velocity),
        acceleration_mps2=np.full(5, acceleration),
        jerk_mps3=np.full(5, jerk),
    )
    return replace(path, machine=machine)


@pytest.fixture(scope="session")
def straight(line: Callable[..., Path]) -> Trajectory:
    """Drive all carts a metre, telescopes at rest, with limits a little above the peaks."""
    return at_rest_at_both_ends(limited_to(line(1.0), *(1.001 * PEAKS)))


@pytest.fixture(scope="session")
def curved(path: Path) -> Trajectory:
    """Drive the curve through reachable poses."""
    return at_rest_at_both_ends(limited_to(path, 10.0, 100.0, 1_000.0))
