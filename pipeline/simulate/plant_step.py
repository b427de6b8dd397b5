"""One step of the real machine: five equations in actuator space and its pose, integrated by a Runge-Kutta method."""

from typing import NamedTuple

import casadi as ca
import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.actuator_space.symbolic import equations_function
from pipeline.machine.geometry import Machine
from pipeline.simulate.drives import Drives

_SWEEPS = 6
"""Sweeps over the drives that find which of them dry friction holds; what is left is done in the next steps."""

SIZES = {"q": 5, "qd": 5, "pose": 6, "force": 5, "grip": 5}
"""Parts of the machine's state: actuators, their velocities, the pose, the drives' forces, and dry friction."""
STATE = sum(SIZES.values())


class _Moving(NamedTuple):
    """What moves, and is integrated."""

    q: ca.SX
    qd: ca.SX
    pose: ca.SX

    def plus(self, rate: "_Moving", h: float) -> "_Moving":
        return _Moving(*(value + h * change for value, change in zip(self, rate, strict=True)))


def split_state(state: FloatArray) -> dict[str, FloatArray]:
    """Take states (..., STATE) apart into actuators, velocities, poses, forces and dry friction."""
    parts = np.split(state, np.cumsum(list(SIZES.values()))[:-1], axis=-1)
    return dict(zip(SIZES, parts, strict=True))


def plant_step_function(machine: Machine, drives: Drives, h: float) -> ca.Function:
    """Build (state, command) -> next state, and qdd (5,) at its beginning.

    Integrates over h seconds by the classical Runge-Kutta method of order four

        (M + m) qdd + c(q, qd) + g(q) = F - d qd + f        pose' = d(pose)/dq qd

    with m and d the drives' moving mass and viscous friction. F lags behind the command u as F' = (u - F) / lag, which
    is exact at the stages. The pose closes the links as exactly as it is integrated.

    Dry friction f is held over the step: within plus and minus its largest value, as much of it as brings the drive
    to rest by the end of the step (Moreau's time stepping; Gauss-Seidel sweeps over the five drives). While a drive
    slides that is its largest value, and the order of the method is kept.

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    equations = equations_function(machine)
    state, command = ca.SX.sym("state", STATE), ca.SX.sym("command", 5)
    parts = ca.vertsplit(state, np.cumsum([0, *SIZES.values()]).tolist())
    now, applied, grip = _Moving(*parts[:3]), parts[3], parts[4]
    at_start, in_middle, at_end = (_lagged(applied, command, drives, t) for t in (0.0, h / 2.0, h))

    def rate(at: _Moving, force: ca.SX) -> tuple[_Moving, ca.SX, ca.SX]:
        """Give the rate of what moves, and the factors of the mass matrix."""
        mass, velocity, gravity, pose_by_q = equations(at.pose, at.q, at.qd)
        d, upper, order = ca.ldl(mass + ca.diag(ca.DM(drives.moving_mass_kg)), False)
        right = force - ca.DM(drives.viscous_friction_nspm) * at.qd - velocity - gravity
        qdd = ca.ldl_solve(right, d, upper, order)
        inverse = ca.ldl_solve(ca.SX.eye(5), d, upper, order)
        return _Moving(at.qd, qdd, pose_by_q @ at.qd), inverse, qdd

    first, inverse, free = rate(now, at_start)
    if (drives.dry_friction_n > 0.0).any():
        coming = now.qd + h * (free + inverse @ (in_middle - at_start))
        grip = _grip(coming, h * inverse, grip, drives.dry_friction_n)
        first = first._replace(qd=free + inverse @ grip)
    second = rate(now.plus(first, h / 2.0), in_middle + grip)[0]
    third = rate(now.plus(second, h / 2.0), in_middle + grip)[0]
    fourth = rate(now.plus(third, h), at_end + grip)[0]
    change = _Moving(*(a + 2.0 * b + 2.0 * c + d for a, b, c, d in zip(first, second, third, fourth, strict=True)))
    after = now.plus(change, h / 6.0)
    following = ca.vertcat(*after, at_end, grip)
    names = ["state", "command"], ["next", "qdd"]
    return ca.Function("plant_step", [state, command], [following, first.qd], *names, {"cse": True})


def _lagged(applied: ca.SX, command: ca.SX, drives: Drives, t: float) -> ca.SX:
    """Give the drives' forces t seconds after a new command."""
    lag = drives.force_lag_s
    kept = np.where(lag > 0.0, np.exp(-t / np.where(lag > 0.0, lag, 1.0)), 0.0)
    return command + ca.DM(kept) * (applied - command)


def _grip(coming: ca.SX, mobility: ca.SX, guess: ca.SX, most: FloatArray) -> ca.SX:
    """Find the dry friction (5,) that stops each drive at the end of the step, as far as it can.

    `coming` are the velocities without it, `mobility` how much of them a newton takes.
    """
    grip = ca.vertsplit(guess)
    for _ in range(_SWEEPS):
        for k in range(5):
            velocity = coming[k] + sum(mobility[k, j] * grip[j] for j in range(5))
            grip[k] = ca.fmin(ca.fmax(grip[k] - velocity / mobility[k, k], -most[k]), most[k])
    return ca.vertcat(*grip)
