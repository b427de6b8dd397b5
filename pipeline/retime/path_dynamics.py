"""A path and the machine's dynamics along it: derivatives of q(s), and coefficients of the forces in motion.

Forces of drives and links are gravity (and dry friction, opposing the motion) plus a part that is linear in
accelerations and quadratic in velocities. Along a path they are a sdd + b sd^2 + c, with sd and sdd the derivatives of
s(t) by time.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline

from pipeline.arrays import FloatArray
from pipeline.machine.dynamics import inverse_dynamics
from pipeline.machine.geometry import Machine
from pipeline.refine.motion import pose_derivatives
from pipeline.refine.result import Path, directions_of

TABLE_POINTS = 2_001
"""Points of s at which kinematics and dynamics are evaluated."""
_FORCES = ("tcp1", "tcp2", "a", "b", "c")
"""Fields that take forward kinematics or dynamics to evaluate."""


@dataclass(frozen=True, eq=False)
class PathDynamics:
    """A path and the machine's dynamics along it, at n places.

    Attributes
    ----------
    s : (n,)
        Path parameter.
    q1, q2, q3 : (n, 5)
        First three derivatives of the actuators' positions by s.
    tcp1, tcp2 : (n, 3)
        First two derivatives of the TCP's position by s; no columns where no limit needs them.
    a, b, c : (n, 11)
        Coefficients of the forces of drives (5) and links (6), without friction; no columns without masses.
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

    def friction(self) -> FloatArray:
        """Compute the drive forces that overcome dry friction while s grows, sign(q') F. Shape (n, 5).

        Actuators that stand still have none: the sign of their q' is only rounding.
        """
        masses = self.machine.masses
        if masses is None:
            return np.zeros_like(self.q1)
        return directions_of(self.q1) * masses.friction_n


@dataclass(frozen=True, eq=False)
class PathDynamicsTable:
    """Path dynamics on a grid, interpolated in between.

    The derivatives of q are exact everywhere; kinematics and dynamics are evaluated on the grid only, and interpolated
    by cubic splines.
    """

    path: Path
    grid: PathDynamics
    between: CubicSpline | None

    def at(self, s: FloatArray) -> PathDynamics:
        """Evaluate at s (n,)."""
        widths = [getattr(self.grid, name).shape[1] for name in _FORCES]
        values = np.zeros((len(s), 0)) if self.between is None else self.between(s)
        parts = np.split(values, np.cumsum(widths)[:-1], axis=1)
        return PathDynamics(self.path.machine, s, *_derivatives(self.path, s), *parts)


def grid(points: int) -> FloatArray:
    """Space points in [0, 1] by cosines, densely at both ends, where s moves slowly and even cells would last long."""
    return np.asarray(0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, points))))


def tabulate_dynamics(path: Path, s: FloatArray) -> PathDynamicsTable:
    """Tabulate path dynamics on a grid s (n,), ascending from 0 to 1."""
    evaluated = evaluate_dynamics(path, s)
    columns = np.concatenate([getattr(evaluated, name) for name in _FORCES], axis=1)
    return PathDynamicsTable(path, evaluated, CubicSpline(s, columns) if columns.size else None)


@lru_cache(maxsize=4)
def dynamics_table(path: Path, points: int) -> PathDynamicsTable:
    """Tabulate path dynamics on a cosine grid of this many points; the tables of the last paths are kept."""
    return tabulate_dynamics(path, grid(points))


def evaluate_dynamics(path: Path, s: FloatArray) -> PathDynamics:
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
    return PathDynamics(machine, s, q1, q2, q3, tcp1, tcp2, a, b, c)


def needs_kinematics(machine: Machine) -> bool:
    """Check whether limits need more than the actuators' own motion: forces, or the motion of the TCP."""
    return machine.masses is not None or bool(np.isfinite([machine.tcp_speed_mps, machine.tcp_acceleration_mps2]).any())


def _derivatives(path: Path, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    first, second, third = (path.q(s, order) for order in (1, 2, 3))
    return first, second, third
