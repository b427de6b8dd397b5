"""What a time law makes of a path: every limited quantity as a polynomial in the derivatives of s(t).

At a place s, with sd, sdd, sddd for the derivatives of s by time and dashes for those by s:

    velocity      q' sd
    acceleration  q' sdd + q'' sd^2
    jerk          q' sddd + 3 q'' sd sdd + q''' sd^3
    force         a sdd + b sd^2 + c

The last holds for drives and links alike, since their forces are gravity (and dry friction, against the direction of
motion) and, for the rest, linear in accelerations and quadratic in velocities.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline

from pipeline.arrays import FloatArray
from pipeline.machine.dynamics import inverse_dynamics
from pipeline.machine.geometry import Machine
from pipeline.refine.motion import pose_derivatives
from pipeline.refine.result import Path

TABLE_POINTS = 2_001
"""Places at which kinematics and dynamics are evaluated."""
_FORCES = ("tcp1", "tcp2", "a", "b", "c")
"""What takes forward kinematics or dynamics to evaluate."""
_STILL, _STILL_M = 1e-9, 1e-12
"""An actuator stands still where its |q'| is no more than this part of the largest, and this many metres."""


@dataclass(frozen=True, eq=False)
class Terms:
    """A path at the places s (n,).

    Attributes
    ----------
    q1, q2, q3 : (n, 5)
        First three derivatives of the actuators' positions by s.
    tcp1, tcp2 : (n, 3)
        First two derivatives of the TCP's position by s; no columns where nothing asks for them.
    a, b, c : (n, 11)
        Coefficients of the forces of drives and links, without friction; no columns where the machine has no masses.
    """

    machine: Machine
    s: FloatArray
    q1: FloatArray
    q2: FloatArray
    q3: FloatArray
    tcp1: FloatArray
    tcp2: FloatArray
    a: FloatArray
    b: FloatArray
    c: FloatArray

    def values(self, sd: FloatArray, sdd: FloatArray, sddd: FloatArray) -> dict[str, FloatArray]:
        """Every quantity for derivatives of s (n,) at these places, (n, subjects) each, by the names in `limits`.

        Quantities of the TCP are magnitudes, all others have a sign; forces are there with masses only, the TCP's
        with masses or limits of its own. A machine that stands has no friction to overcome.
        """
        v, w, j = sd[:, None], sdd[:, None], sddd[:, None]
        found = {
            "velocity": self.q1 * v,
            "acceleration": self.q1 * w + self.q2 * v**2,
            "jerk": self.q1 * j + 3.0 * self.q2 * v * w + self.q3 * v**3,
        }
        if self.tcp1.size:
            found["tcp_speed"] = np.linalg.norm(self.tcp1 * v, axis=1, keepdims=True)
            found["tcp_acceleration"] = np.linalg.norm(self.tcp1 * w + self.tcp2 * v**2, axis=1, keepdims=True)
        if self.machine.masses is not None:
            force = self.a * w + self.b * v**2 + self.c
            moving = (v != 0.0) | (w != 0.0)
            found["force"], found["link_force"] = force[:, :5] + self.friction() * moving, force[:, 5:]
        return found

    def resting(self) -> dict[str, FloatArray]:
        """Forces just to hold the machine, and to overcome dry friction while s begins to grow; none without masses."""
        if self.machine.masses is None:
            return {}
        return {"force": self.c[:, :5] + self.friction(), "link_force": self.c[:, 5:]}

    def friction(self) -> FloatArray:
        """Force of the drives against dry friction while s grows: sign(q') times theirs. Shape (n, 5).

        What rounding leaves of the q' of an actuator that stands still has no sign.
        """
        masses, speed = self.machine.masses, np.abs(self.q1)
        if masses is None:
            return np.zeros_like(self.q1)
        moves = speed > _STILL * speed.max(axis=1, keepdims=True) + _STILL_M
        against: FloatArray = np.sign(self.q1) * moves * masses.friction_n
        return against


@dataclass(frozen=True, eq=False)
class TermsTable:
    """Terms on a grid, from which those anywhere between follow.

    The derivatives of q are the spline's own everywhere; what takes kinematics and dynamics is interpolated by cubic
    splines, so that these are evaluated on the grid and never again.
    """

    path: Path
    grid: Terms
    between: CubicSpline | None

    def at(self, s: FloatArray) -> Terms:
        """Terms at s (n,)."""
        widths = [getattr(self.grid, name).shape[1] for name in _FORCES]
        values = np.zeros((len(s), 0)) if self.between is None else self.between(s)
        parts = np.split(values, np.cumsum(widths)[:-1], axis=1)
        return Terms(self.path.machine, s, *_derivatives(self.path, s), *parts)


def grid(points: int) -> FloatArray:
    """Points of s in [0, 1], dense at both ends (cosine spacing): there s moves slowly, and even cells take long."""
    s: FloatArray = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, points)))
    return s


def terms_table(path: Path, s: FloatArray) -> TermsTable:
    """Evaluate path and dynamics on the grid s (n,), ascending from 0 to 1."""
    evaluated = path_terms(path, s)
    columns = np.concatenate([getattr(evaluated, name) for name in _FORCES], axis=1)
    return TermsTable(path, evaluated, CubicSpline(s, columns) if columns.size else None)


@lru_cache(maxsize=4)
def table_of(path: Path, points: int) -> TermsTable:
    """Evaluate path and dynamics on a grid of so many points; the last paths' tables are kept."""
    return terms_table(path, grid(points))


def path_terms(path: Path, s: FloatArray) -> Terms:
    """Evaluate a path, and the machine's dynamics along it, at s (n,).

    Raises
    ------
    ForwardKinematicsError
        Where the closure equations have no solution near the path's known poses.
    """
    machine, masses = path.machine, path.machine.masses
    q1, q2, q3 = _derivatives(path, s)
    tcp1 = tcp2 = a = b = c = np.zeros((len(s), 0))
    if needs_kinematics(machine):
        pose, first, second, _ = pose_derivatives(path, s)
        tcp1, tcp2 = first[:, :3], second[:, :3]
    if masses is not None:
        carts = path.q(s)[:, :3]

        def forces(rate: FloatArray, acceleration: FloatArray, cart_acceleration: FloatArray) -> FloatArray:
            found = inverse_dynamics(machine, masses, pose, carts, rate, acceleration, cart_acceleration)
            return np.concatenate([found.drive_n, found.link_n], axis=1)

        still, carts_still = np.zeros_like(pose), np.zeros_like(carts)
        c = forces(still, still, carts_still)
        a = forces(still, first, q1[:, :3]) - c
        b = forces(first, second, q2[:, :3]) - c
    return Terms(machine, s, q1, q2, q3, tcp1, tcp2, a, b, c)


def needs_kinematics(machine: Machine) -> bool:
    """Tell whether limits are of more than the actuators' own motion: of forces or of the TCP."""
    return machine.masses is not None or bool(np.isfinite([machine.tcp_speed_mps, machine.tcp_acceleration_mps2]).any())


def _derivatives(path: Path, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    first, second, third = (path.q(s, order) for order in (1, 2, 3))
    return first, second, third
