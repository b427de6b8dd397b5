"""How good a motion is, in numbers that no plot is needed for: reversals of its actuators, and its duration.

The durations are compared with the least that any path between the same ends takes: the longest of the times that the
actuators, each on its own, need from rest to rest (`least_times_s`).
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.retime.quality.least_time import least_times_s
from pipeline.retime.quantities import limits
from pipeline.retime.result import Trajectory, stretched

COUNTED_SHARE = 0.05
"""Part of its limit above which a velocity or an acceleration has a sign that counts."""
_INSTANTS = 10_001
_NO_DISTANCE_M = 1e-9
"""Distance between start and goal that is rounding."""


@dataclass(frozen=True)
class MotionQuality:
    """A motion at full speed, without waiting, in numbers.

    Attributes
    ----------
    velocity_sign_changes, acceleration_sign_changes : tuple of int
        How often the sign changes, per actuator; magnitudes below 5 % of the limit have no sign.
    motion_s : float
        Duration.
    least_times_s : tuple of float
        The least time of each actuator alone from its start to its goal, whatever the path.
    """

    velocity_sign_changes: tuple[int, ...]
    acceleration_sign_changes: tuple[int, ...]
    motion_s: float
    least_times_s: tuple[float, ...]

    @property
    def least_time_s(self) -> float:
        """The largest of the least times: no motion between these ends is faster."""
        return max(self.least_times_s)

    @property
    def time_ratio(self) -> float | None:
        """Duration against the largest of the least times; None if the goal is the start."""
        return self.motion_s / self.least_time_s if self.least_time_s > 0.0 else None


def measure_quality(trajectory: Trajectory, speed: float = 1.0) -> MotionQuality:
    """Count the sign changes of a motion, and compare its duration with the least one.

    Parameters
    ----------
    trajectory : Trajectory
        The motion; its waiting times are left out.
    speed : float
        The fraction of full speed at which it was planned (`retime.speed`); it is measured at full speed.
    """
    path, machine = trajectory.path, trajectory.path.machine
    motion_s = trajectory.motion_s * speed
    full = stretched(trajectory, sum(trajectory.dwell_s) + motion_s)
    t = full.dwell_s[0] + np.linspace(0.0, motion_s, _INSTANTS)
    allowed = limits(machine)
    velocity, acceleration = (
        sign_changes(full.q(t, order) / allowed[name]) for order, name in ((1, "velocity"), (2, "acceleration"))
    )
    distances_m = np.abs(np.diff(path.q(np.array([0.0, 1.0])), axis=0))[0]
    distances_m[distances_m < _NO_DISTANCE_M] = 0.0
    times = least_times_s(machine, distances_m, jerk=not trajectory.jerk_jumps)
    return MotionQuality(velocity, acceleration, motion_s, tuple(times.tolist()))


def sign_changes(shares: FloatArray, counted: float = COUNTED_SHARE) -> tuple[int, ...]:
    """Count the sign changes of each column of fractions of a limit (n, m), leaving out those below `counted`."""
    return tuple(int(np.count_nonzero(np.diff(np.sign(share[np.abs(share) > counted])))) for share in shares.T)
