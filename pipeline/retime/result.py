"""What stage three makes: a trajectory, the path with a law that says where on it the machine is when."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PPoly

from pipeline.machine.geometry import FloatArray
from pipeline.refine.result import Path


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A path and its time law s(t); the machine rests at s = 0 before it and at s = 1 after it.

    Attributes
    ----------
    path : Path
        The curve of actuator positions that is driven.
    time_law : PPoly
        s(t), continuously differentiable and piecewise quadratic: the path acceleration is constant between
        breakpoints, so that s(t) is exact and needs no integration.
    """

    path: Path
    time_law: PPoly

    @classmethod
    def from_breakpoints(
        cls, path: Path, t_s: FloatArray, s: FloatArray, sd: FloatArray, sdd: FloatArray
    ) -> "Trajectory":
        """Build the trajectory from times, s, path velocities and the path accelerations that follow. Shapes (n,)."""
        return cls(path, PPoly(np.stack([sdd[:-1] / 2.0, sd[:-1], s[:-1]]), t_s))

    def breakpoints(self) -> dict[str, FloatArray]:
        """Return the arrays t_s, s, sd, sdd (n,) from which `from_breakpoints` makes exactly this time law."""
        half, sd, s = self.time_law.c
        return {
            "t_s": self.time_law.x.copy(),
            "s": np.append(s, 1.0),
            "sd": np.append(sd, 0.0),
            "sdd": np.append(2.0 * half, 0.0),
        }

    @property
    def duration_s(self) -> float:
        """Time from rest at the start to rest at the goal."""
        return float(self.time_law.x[-1])

    def s(self, t_s: FloatArray | float, derivative: int = 0) -> FloatArray:
        """Path parameter at times t, or its derivative by time; the second jumps and is taken from the right."""
        t = np.asarray(t_s, dtype=float)
        moving = (t >= 0.0) & (t < self.duration_s)
        value = self.time_law(t, nu=derivative)
        if derivative > 0:
            return np.where(moving, value, 0.0)
        # Rounding in a piece must not carry s past the ends of the path.
        return np.where(moving, np.clip(value, 0.0, 1.0), np.where(t < 0.0, 0.0, 1.0))

    def q(self, t_s: FloatArray | float, derivative: int = 0) -> FloatArray:
        """Actuator positions, velocities or accelerations (metres, seconds) at times t. Shape (..., 5).

        q, q' s_d and q'' s_d^2 + q' s_dd by the chain rule. Accelerations jump at breakpoints and are taken from
        the right: what follows from that instant on; zero at the end, where the machine stays.

        Raises
        ------
        ValueError
            For derivatives above the second, which do not exist where the path acceleration jumps.
        """
        s = self.s(t_s)
        if derivative == 0:
            return self.path.q(s)
        sd = self.s(t_s, 1)[..., None]
        if derivative == 1:
            return self.path.q(s, 1) * sd
        if derivative == 2:
            return self.path.q(s, 2) * sd**2 + self.path.q(s, 1) * self.s(t_s, 2)[..., None]
        raise ValueError(f"a trajectory has derivatives 0 to 2, not {derivative}")

    def pose(self, t_s: FloatArray | float) -> FloatArray:
        """Poses (x, y, z, rx, ry, rz) at times t (n,). Shape (n, 6).

        Raises
        ------
        ForwardKinematicsError
            Where the closure equations have no solution near the path's known poses.
        """
        return self.path.pose(self.s(t_s))


def stretched(trajectory: Trajectory, duration_s: float) -> Trajectory:
    """Drive the same path in another time: with f = duration_s / old, velocities shrink by f, accelerations by f^2.

    Raises
    ------
    ValueError
        When the new duration is not positive.
    """
    if not duration_s > 0.0:
        raise ValueError(f"a trajectory cannot last {duration_s:g} s")
    factor = duration_s / trajectory.duration_s
    points = trajectory.breakpoints()
    t = points["t_s"] * factor
    t[-1] = duration_s
    return Trajectory.from_breakpoints(
        trajectory.path, t_s=t, s=points["s"], sd=points["sd"] / factor, sdd=points["sdd"] / factor**2
    )


@dataclass(frozen=True, eq=False)
class TrajectorySamples:
    """A trajectory once per period: row k is at k times the period, the last row is the goal at rest.

    Attributes
    ----------
    period_s : float
        Time between two rows.
    t_s : (n,)
        Time since the start.
    q_m, qd_mps, qdd_mps2 : (n, 5)
        Actuator positions, velocities and the accelerations that follow from that instant on.
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
