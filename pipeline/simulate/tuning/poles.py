"""Frozen-time poles of the controlled machine: how fast deviations die out at each instant of a motion."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine.actuator_space.symbolic import equations_function, linearised_function
from pipeline.machine.geometry import Machine
from pipeline.simulate.controller import delayed_periods
from pipeline.simulate.drives import Drives
from pipeline.simulate.motion import Motion

_GONE = 1e-12
"""Magnitude of a pole of the sampled loop below which a deviation is gone within a period."""


@dataclass(frozen=True, eq=False)
class Linearised:
    """The machine near n instants of a motion: M dqdd + C dqd + K dq = dF, all (n, 5, 5), in kg, Ns/m and N/m."""

    t_s: FloatArray
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray

    def take(self, rows: IntArray) -> "Linearised":
        """Keep only these instants, in their order."""
        return Linearised(self.t_s[rows], self.mass[rows], self.damping[rows], self.stiffness[rows])

    def both_ways(self) -> "Linearised":
        """Add the way back, on which the forces of velocities, quadratic in qd, have the opposite derivatives."""
        return Linearised(
            np.tile(self.t_s, 2),
            np.tile(self.mass, (2, 1, 1)),
            np.concatenate([self.damping, -self.damping]),
            np.tile(self.stiffness, (2, 1, 1)),
        )


@dataclass(frozen=True, eq=False)
class SampledMachine:
    """Machine and drives over a period T with constant commands: X+ = A X + B u, X = (dq, dqd, lagging forces).

    Attributes
    ----------
    A, B : (n, m, m), (n, m, 5)
        At n instants t_s (n,), with the drives' mass, viscous friction and lag.
    period_s : float
        T.
    """

    t_s: FloatArray
    A: FloatArray
    B: FloatArray
    period_s: float


@dataclass(frozen=True, eq=False)
class Poles:
    """The controlled machine at n instants t_s (n,).

    Attributes
    ----------
    damping : (n,)
        Least damping ratio of any pole s, -Re s / |s|: 1 without oscillation, negative where deviations grow.
    rightmost_per_s : (n,)
        Largest real part: deviations decay, or grow, at least like exp of it times t.
    """

    t_s: FloatArray
    damping: FloatArray
    rightmost_per_s: FloatArray


def linearised(machine: Machine, motion: Motion, rows: IntArray) -> Linearised:
    """Linearise the forces of a motion at some of its rows, with velocities and accelerations there.

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    pose, q, qd, qdd = (values[rows].T for values in (motion.pose, motion.q_m, motion.qd_mps, motion.qdd_mps2))
    mass = _stacked(equations_function(machine).map(len(rows))(pose, q, qd)[0])
    stiffness, damping = (_stacked(part) for part in linearised_function(machine).map(len(rows))(pose, q, qd, qdd))
    return Linearised(motion.t_s[rows], mass, damping, stiffness)


def _stacked(columns: object) -> FloatArray:
    """Take matrices (5, 5 n) apart. Shape (n, 5, 5)."""
    return np.asarray(columns, dtype=float).reshape(5, -1, 5).transpose(1, 0, 2)


def sampled_machine(linear: Linearised, drives: Drives, period_s: float) -> SampledMachine:
    """Integrate machine and drives over a period with constant commands, by matrix exponentials."""
    n, lagging = len(linear.t_s), np.flatnonzero(drives.force_lag_s > 0.0)
    inverse = np.linalg.inv(linear.mass + np.diag(drives.moving_mass_kg))
    m = 10 + len(lagging)
    whole = np.zeros((n, m + 5, m + 5))
    whole[:, :5, 5:10] = np.eye(5)
    whole[:, 5:10, :5] = -inverse @ linear.stiffness
    whole[:, 5:10, 5:10] = -inverse @ (linear.damping + np.diag(drives.viscous_friction_nspm))
    whole[:, 5:10, m:] = inverse
    for state, drive in enumerate(lagging, 10):
        whole[:, 5:10, state] = inverse[:, :, drive]
        whole[:, 5:10, m + drive] = 0.0
        whole[:, state, state], whole[:, state, m + drive] = np.array([-1.0, 1.0]) / drives.force_lag_s[drive]
    over = expm(period_s * whole)
    return SampledMachine(linear.t_s, over[:, :m, :m], over[:, :m, m:], period_s)


def loop_poles(sampled: SampledMachine, drives: Drives) -> Poles:
    """Compute the poles of machine and controllers, with sampling, held forces, lags and delays.

    The loop is that of `controller_function` without its limits; its eigenvalues z per period T are poles s = ln z / T.
    """
    z = np.linalg.eigvals(_loop(sampled, drives))
    magnitude = np.abs(z)
    s = (np.log(np.maximum(magnitude, _GONE)) + 1j * np.angle(z)) / sampled.period_s
    damping = np.where(magnitude > _GONE, -s.real / np.maximum(np.abs(s), _GONE), 1.0)
    return Poles(sampled.t_s, damping.min(axis=1), s.real.max(axis=1))


def _loop(sampled: SampledMachine, drives: Drives) -> FloatArray:
    """Matrices of the whole loop over a period: machine, last positions, integrals, commands under way."""
    n, m, _ = sampled.A.shape
    T, delays = sampled.period_s, np.array(delayed_periods(drives, sampled.period_s))
    integrating = np.flatnonzero(drives.integral_gain_npm > 0.0)
    last, integral, queue = m, m + 5, m + 5 + len(integrating)
    size = queue + 5 * int(delays.max())
    stepped = drives.encoder_step_m > 0.0
    error = np.zeros((5, size))
    error[:, :5] = -np.diag(drives.position_gain_per_s + np.where(stepped, 1.0 / T, 0.0))
    error[:, 5:10] = -np.diag(np.where(stepped, 0.0, 1.0))
    error[:, last : last + 5] = np.diag(np.where(stepped, 1.0 / T, 0.0))
    command = drives.velocity_gain_nspm[:, None] * error
    command[integrating, np.arange(integral, queue)] += 1.0
    # Commands that are d periods old act now: the newest of the queue is at its end.
    waiting = np.vstack([np.eye(size)[queue:], command])
    acting = np.array([waiting[5 * (int(delays.max()) - d) + k] for k, d in enumerate(delays)])
    loop = np.zeros((n, size, size))
    loop[:, :m, :m] = sampled.A
    loop[:, :m] += sampled.B @ acting
    loop[:, last : last + 5, :5] = np.eye(5)
    loop[:, integral:queue] = (
        np.eye(size)[integral:queue] + T * (drives.integral_gain_npm[:, None] * error)[integrating]
    )
    loop[:, queue:] = waiting[5:]
    return loop
