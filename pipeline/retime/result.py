"""Results of stage three: a trajectory, which is a path and its time law s(t), and its samples."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import PPoly

from pipeline.arguments import require_array, require_number, require_whole
from pipeline.arrays import FloatArray
from pipeline.errors import ArgumentError
from pipeline.machine.actuator_space.controller_units import ControllerUnits
from pipeline.refine.result import Path

_MOST_DERIVATIVE = 10
_ROUNDING = 1e-14
"""Part of the motion's duration that is rounding: this close to its end, the motion is over."""


@dataclass(frozen=True)
class TimingReport:
    """How good a time law is, and how it was found.

    Attributes
    ----------
    jerk_limited : bool
        Jerk was limited, too; otherwise accelerations jump.
    fastest_s : float
        Shortest duration under all limits but those of jerk; NaN for a path that came with a time law.
    bound_s : float
        Lower bound on that duration, from an independent convex problem; NaN for such a path.
    motion_s : float
        Duration of the time law as it was found, before it was slowed down and fitted to the period.
    grid_points : int
        Points of the planner's last grid; zero without a planner.
    pieces, rounds, iterations : int
        Pieces of the time law with limited jerk, programs solved for it, and their iterations; zero without.
    """

    jerk_limited: bool
    fastest_s: float
    bound_s: float
    motion_s: float
    grid_points: int
    pieces: int = 0
    rounds: int = 0
    iterations: int = 0

    @property
    def gap(self) -> float:
        """Part of the duration without jerk limits that the bound leaves open."""
        return 1.0 - self.bound_s / self.fastest_s

    @property
    def jerk_cost(self) -> float:
        """Part by which limited jerk makes the motion longer than the fastest one."""
        return self.motion_s / self.fastest_s - 1.0


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A path and its time law s(t); the machine rests at s = 0 before it and at s = 1 after it.

    Attributes
    ----------
    path : Path
        The curve in actuator space.
    time_law : PPoly
        s(t) from the beginning of the motion: piecewise polynomial, so that it is exact and needs no integration. Of
        degree two where accelerations jump between pieces, of degree four where jerk is continuous.
    dwell_s : (float, float)
        How long the machine waits at the start before the motion, and at the goal after it.
    timing : TimingReport or None
        How the time law was found; None when that is not known.

    Raises
    ------
    ArgumentError
        If the time law does not begin at zero, or a waiting time is negative or not finite.
    """

    path: Path
    time_law: PPoly
    dwell_s: tuple[float, float] = (0.0, 0.0)
    timing: TimingReport | None = None

    def __post_init__(self) -> None:
        require_array("dwell_s", self.dwell_s, (2,), least=0.0)
        require_array("the coefficients of the time law", self.time_law.c, ("k", "n"))
        if not (
            self.time_law.x[0] == 0.0 and (np.diff(require_array("its times", self.time_law.x, ("n",))) > 0.0).all()
        ):
            raise ArgumentError("the time law: expected times that increase from zero")

    @classmethod
    def from_breakpoints(
        cls, path: Path, t_s: FloatArray, s: FloatArray, sd: FloatArray, sdd: FloatArray
    ) -> "Trajectory":
        """Build a trajectory from times, s, path speeds and the path accelerations that follow them. Shapes (n,)."""
        return cls(path, PPoly(np.stack([sdd[:-1] / 2.0, sd[:-1], s[:-1]]), t_s))

    @property
    def motion_s(self) -> float:
        """Time from the beginning of the motion to its end."""
        return float(self.time_law.x[-1])

    @property
    def duration_s(self) -> float:
        """Time from rest at the start to rest at the goal, waiting at both ends included."""
        return self.dwell_s[0] + self.motion_s + self.dwell_s[1]

    @property
    def jerk_jumps(self) -> bool:
        """True when accelerations jump between pieces, so that jerk is unbounded."""
        return bool(self.time_law.c.shape[0] < 4)

    def s(self, t_s: FloatArray | float, derivative: int = 0) -> FloatArray:
        """Evaluate s(t) or a derivative by time; where it jumps, the value after the jump.

        The machine rests before the start, and at any time after the end.

        Raises
        ------
        ArgumentError
            If a time is no finite number, or the derivative is below zero.
        """
        derivative = require_whole("derivative", derivative, 0, _MOST_DERIVATIVE)
        t = require_array("t_s", t_s, ("...",)) - self.dwell_s[0]
        moving = (t >= 0.0) & (t < self.motion_s * (1.0 - _ROUNDING))
        value = self.time_law(t, nu=derivative)
        if derivative > 0:
            return np.where(moving, value, 0.0)
        # Rounding must not carry s past the ends of the path.
        return np.where(moving, np.clip(value, 0.0, 1.0), np.where(t < 0.0, 0.0, 1.0))

    def q(self, t_s: FloatArray | float, derivative: int = 0) -> FloatArray:
        """Evaluate actuator positions, velocities, accelerations or jerks (metres, seconds) at times t. Shape (..., 5).

        By the chain rule: q, q' sd, q'' sd^2 + q' sdd, q''' sd^3 + 3 q'' sd sdd + q' sddd. Where they jump, the value
        is that after the jump; at the end, where the machine stays, it is zero.

        Raises
        ------
        ArgumentError
            If a time is no finite number; for derivatives below zero or above the third, and for the third where
            accelerations jump.
        """
        most = 2 if self.jerk_jumps else 3
        if derivative not in range(most + 1):
            raise ArgumentError(f"derivative: this trajectory has derivatives 0 to {most}, not {derivative}")
        s = self.s(t_s)
        if derivative == 0:
            return self.path.q(s)
        sd = self.s(t_s, 1)[..., None]
        if derivative == 1:
            return self.path.q(s, 1) * sd
        sdd = self.s(t_s, 2)[..., None]
        if derivative == 2:
            return self.path.q(s, 2) * sd**2 + self.path.q(s, 1) * sdd
        sddd = self.s(t_s, 3)[..., None]
        return self.path.q(s, 3) * sd**3 + 3.0 * self.path.q(s, 2) * sd * sdd + self.path.q(s, 1) * sddd

    def pose(self, t_s: FloatArray | float) -> FloatArray:
        """Evaluate poses (x, y, z, rx, ry, rz) at times t (n,). Shape (n, 6).

        Raises
        ------
        ForwardKinematicsError
            Where the closure equations have no solution near the path's known poses.
        """
        return self.path.pose(self.s(t_s))


def stretched(trajectory: Trajectory, duration_s: float) -> Trajectory:
    """Drive the same path in another time, with the waiting times unchanged.

    With f = new motion / old, velocities are divided by f, accelerations by f^2 and jerks by f^3; forces approach those
    at rest.

    Raises
    ------
    ArgumentError
        When no time is left for the motion, or the duration is no finite number.
    """
    motion = duration_s - sum(trajectory.dwell_s)
    if not 0.0 < motion < np.inf:
        raise ArgumentError(
            f"duration_s: a trajectory that waits {sum(trajectory.dwell_s):g} s cannot last {duration_s:g} s"
        )
    factor = motion / trajectory.motion_s
    time_law = trajectory.time_law
    t = time_law.x * factor
    t[-1] = motion
    powers = np.arange(len(time_law.c) - 1, -1, -1)
    return replace(trajectory, time_law=PPoly(time_law.c / factor ** powers[:, None], t))


def slowed(trajectory: Trajectory, speed: float) -> Trajectory:
    """Drive at a fraction of the speed (above 0, at most 1), with the waiting times unchanged.

    Raises
    ------
    ArgumentError
        If the fraction is something else: faster than planned, the motion would exceed its limits.
    """
    speed = require_number("speed", speed, above=0.0, largest=1.0)
    return stretched(trajectory, sum(trajectory.dwell_s) + trajectory.motion_s / speed)


@dataclass(frozen=True, eq=False)
class TrajectorySamples:
    """A trajectory sampled once per period: row k is at k times the period, the last row is the goal at rest.

    Attributes
    ----------
    period_s : float
        Time between two rows.
    t_s : (n,)
        Time since the start.
    q_m, qd_mps, qdd_mps2 : (n, 5)
        Actuator positions, velocities, and the accelerations from that instant on.
    pose : (n, 6)
        x, y, z, rx, ry, rz by forward kinematics.
    kappa : (n,)
        Condition number of H.
    """

    period_s: float
    t_s: FloatArray
    q_m: FloatArray
    qd_mps: FloatArray
    qdd_mps2: FloatArray
    pose: FloatArray
    kappa: FloatArray

    def __len__(self) -> int:
        return len(self.t_s)

    @property
    def duration_s(self) -> float:
        """Time of the last row."""
        return float(self.t_s[-1])

    def for_controller(self, units: ControllerUnits) -> "TrajectorySamples":
        """Give the same samples with actuators in the units of the controller."""
        return replace(
            self,
            q_m=units.to_controller(self.q_m),
            qd_mps=units.rates_to_controller(self.qd_mps),
            qdd_mps2=units.rates_to_controller(self.qdd_mps2),
        )
