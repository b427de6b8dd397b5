"""The controllers of the drives: P over the position, PI over the velocity, feed-forward, once per period."""

import casadi as ca
import numpy as np

from pipeline.arrays import FloatArray
from pipeline.simulate.drives import Drives

SMOOTH_MPS = 1e-3
"""Friction is fed forward as F tanh(velocity / this): a command of its sign alone would chatter around rest."""


def delayed_periods(drives: Drives, period_s: float) -> tuple[int, ...]:
    """Round each drive's delay to whole periods."""
    return tuple(round(float(delay / period_s)) for delay in drives.delay_s)


def controller_size(drives: Drives, period_s: float) -> int:
    """Count the states of the controllers: integrals, last positions, and the commands under way."""
    return 10 + 5 * max(delayed_periods(drives, period_s))


def controller_start(drives: Drives, period_s: float, measured_m: FloatArray, force_n: FloatArray) -> FloatArray:
    """Give the state of controllers at rest at measured positions (5,), forces (5,) under way, with empty integrals."""
    queue = np.tile(force_n, max(delayed_periods(drives, period_s)))
    return np.concatenate([np.zeros(5), quantised(measured_m, drives.encoder_step_m), queue])


def quantised(q_m: FloatArray, step_m: FloatArray) -> FloatArray:
    """Round positions (..., 5) to the steps of their encoders."""
    step = np.where(step_m > 0.0, step_m, 1.0)
    return np.where(step_m > 0.0, step * np.floor(q_m / step + 0.5), q_m)


def feed_forward(drives: Drives, force_n: FloatArray, qd_mps: FloatArray, qdd_mps2: FloatArray) -> FloatArray:
    """Compute the forces (n, 5) that are fed forward, for the model's forces and the motion, all (n, 5).

    The model's force includes that of the drives' moving mass; friction is F tanh(qd / 1 mm/s) + d qd.
    """
    friction = drives.dry_friction_n * np.tanh(qd_mps / SMOOTH_MPS) + drives.viscous_friction_nspm * qd_mps
    rigid = force_n + drives.moving_mass_kg * qdd_mps2
    return np.asarray(drives.force_forward * rigid + drives.friction_forward * friction)


def controller_function(drives: Drives, period_s: float) -> ca.Function:
    """Build (q, qd, state, reference) -> the force that is commanded (5,), next state; reference = (q, qd, feed).

        u = kv e_v + I + feed,   e_v = ff qd_ref + kp (q_ref - q) - qd,   I += kv / Tn e_v period

    with u within its saturation; the integral of a saturated drive keeps still where it would push further. q is
    rounded to the encoder's step, and qd is then its difference over a period; without steps both are exact. A delayed
    command waits for whole periods.
    """
    q, qd, reference = ca.SX.sym("q", 5), ca.SX.sym("qd", 5), ca.SX.sym("reference", 15)
    state = ca.SX.sym("state", controller_size(drives, period_s))
    integral, last, queue = state[:5], state[5:10], state[10:]
    stepped = ca.DM(np.where(drives.encoder_step_m > 0.0, 1.0, 0.0))
    step = ca.DM(np.where(drives.encoder_step_m > 0.0, drives.encoder_step_m, 1.0))
    measured = stepped * step * ca.floor(q / step + 0.5) + (1.0 - stepped) * q
    velocity = stepped * (measured - last) / period_s + (1.0 - stepped) * qd
    wanted = ca.DM(drives.velocity_forward) * reference[5:10]
    error = wanted + ca.DM(drives.position_gain_per_s) * (reference[:5] - measured) - velocity
    raw = ca.DM(drives.velocity_gain_nspm) * error + integral + reference[10:]
    push, pull = (ca.DM(np.where(np.isfinite(limit), limit, 1e30)) for limit in drives.saturation_n)
    command = ca.fmin(ca.fmax(raw, -pull), push)
    held = ca.logic_and(raw != command, raw * error > 0.0)
    integral += ca.if_else(held, 0.0, ca.DM(drives.integral_gain_npm * period_s) * error)
    most = queue.numel() // 5
    waiting = ca.vertcat(queue, command)
    applied = ca.vertcat(
        *(waiting[5 * (most - periods) + k] for k, periods in enumerate(delayed_periods(drives, period_s)))
    )
    following = ca.vertcat(integral, measured, waiting[5:])
    names = ["q", "qd", "state", "reference"], ["command", "next"]
    return ca.Function("controller", [q, qd, state, reference], [applied, following], *names)
