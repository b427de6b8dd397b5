"""What a motion takes of limits that poses alone do not tell: forces in motion, speed and acceleration of the TCP.

force         F(p, p', p'') + sign(q') friction, by `machine.dynamics.inverse_dynamics`
TCP           |(x', y', z')| and |(x'', y'', z'')|
"""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.dynamics import inverse_dynamics
from pipeline.machine.geometry import ACTUATORS, LINKS, Machine
from pipeline.refine.motion import pose_derivatives
from pipeline.refine.result import Path, directions_of

LOADS = (
    *(f"force of {name}" for name in ACTUATORS),
    *(f"force of link {name}" for name in LINKS),
    "TCP speed",
    "TCP acceleration",
)
"""Names of the columns of `load_shares`."""
_STRETCHES = 5
"""Steps in which a duration is found that keeps the limits; gravity stays, whatever the duration."""


def limits_loads(machine: Machine) -> bool:
    """Tell whether a machine limits any of these."""
    forces = machine.masses is not None and bool(np.isfinite(machine.force_limits_n).any())
    return forces or bool(np.isfinite([machine.tcp_speed_mps, machine.tcp_acceleration_mps2]).any())


def load_shares(path: Path, tau: FloatArray, motion_s: float) -> FloatArray:
    """Compute the share that q(t / T) takes of every limit at tau (n,), for T = `motion_s`. Shape (n, 13)."""
    machine, masses = path.machine, path.machine.masses
    pose, first, second, _ = pose_derivatives(path, tau)
    rate, acceleration = first / motion_s, second / motion_s**2
    tcp = np.column_stack([np.linalg.norm(part[:, :3], axis=1) for part in (rate, acceleration)])
    tcp /= [machine.tcp_speed_mps, machine.tcp_acceleration_mps2]
    if masses is None:
        return np.hstack([np.zeros((len(tau), len(ACTUATORS) + len(LINKS))), tcp])
    carts = path.q(tau)[:, :3]
    found = inverse_dynamics(machine, masses, pose, carts, rate, acceleration, path.q(tau, 2)[:, :3] / motion_s**2)
    drive = found.drive_n + directions_of(path.q(tau, 1)) * masses.friction_n
    forces = np.hstack([drive, found.link_n])
    push, pull = machine.force_limits_n
    return np.hstack([np.maximum(forces / push, -forces / pull), tcp])


def unloaded_motion_s(path: Path, tau: FloatArray, motion_s: float) -> float:
    """Lengthen a duration until q(t / T) keeps these limits at tau (n,), as far as that helps."""
    for _ in range(_STRETCHES):
        largest = float(load_shares(path, tau, motion_s).max())
        if largest <= 1.0:
            break
        motion_s *= largest
    return motion_s
