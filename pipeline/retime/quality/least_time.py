"""The least time of every actuator alone between start and goal, which bounds the duration along any path."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import Machine
from pipeline.retime.quantities import limits


def least_times_s(machine: Machine, distances_m: FloatArray, jerk: bool = True) -> FloatArray:
    """Compute the least time of every actuator from rest to rest over a distance (5,), by `rest_to_rest_s`.

    An actuator that is locked (velocity limit zero) takes none: its distance is checked before planning.
    """
    most = machine.jerk_mps3 if jerk else np.full(len(distances_m), np.inf)
    values = zip(distances_m, limits(machine)["velocity"], machine.acceleration_mps2, most, strict=True)
    return np.array([rest_to_rest_s(*row) if np.isfinite(row[1]) else 0.0 for row in values])


def rest_to_rest_s(distance: float, velocity: float, acceleration: float, jerk: float = np.inf) -> float:
    """Compute the least time over a distance from rest to rest, with zero acceleration at both ends.

    With limits v, a, j, a peak velocity u is reached from rest within u/a + a/j if u > a^2/j, else within
    2 sqrt(u/j), and as much time is needed to stop; both together cover u times either. For distance d the peak
    velocity is v, or where that is too far

        u = (sqrt((a^2/j)^2 + 4 a d) - a^2/j) / 2    if d > 2 a^3/j^2,
        u = (d^2 j / 4)^(1/3)                        else,

    and T = d/u + the time to reach u (Biagiotti, Melchiorri: Trajectory Planning for Automatic Machines and Robots,
    double S velocity profile). Without a jerk limit a^2/j is zero.
    """
    if distance == 0.0:
        return 0.0
    # The speed up to which the acceleration does not reach its limit.
    corner = acceleration**2 / jerk
    if distance > 2.0 * corner * acceleration / jerk:
        peak = (np.sqrt(corner**2 + 4.0 * acceleration * distance) - corner) / 2.0
    else:
        peak = np.cbrt(distance**2 * jerk / 4.0)
    peak = min(float(peak), velocity)
    rise = peak / acceleration + acceleration / jerk if peak > corner else 2.0 * np.sqrt(peak / jerk)
    return float(distance / peak + rise)
