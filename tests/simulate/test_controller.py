"""The controllers, by hand."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.simulate import Drives
from pipeline.simulate.controller import controller_function, controller_start, feed_forward, quantised

PERIOD_S = 1e-3
Q = np.array([0.5, 0.6, 0.7, 1.0, 1.2])
NONE = np.zeros(5)


def command(drives: Drives, state: np.ndarray, q: np.ndarray, qd: np.ndarray, reference: np.ndarray):
    """Compute a command and the next state."""
    return [np.array(part).ravel() for part in controller_function(drives, PERIOD_S)(q, qd, state, reference)]


def test_the_cascade(ideal: Drives) -> None:
    """P over the position with the velocity fed forward, PI over the velocity, and the force fed forward."""
    state = controller_start(ideal, PERIOD_S, Q, NONE)
    off, fast, feed = np.full(5, 1e-3), np.full(5, 0.02), np.arange(5.0)
    force, following = command(ideal, state, Q, NONE, np.concatenate([Q + off, fast, feed]))
    error = fast + ideal.position_gain_per_s * off
    assert force == pytest.approx(ideal.velocity_gain_nspm * error + feed)
    assert following[:5] == pytest.approx(ideal.integral_gain_npm * error * PERIOD_S)


def test_a_saturated_integral_does_not_wind_up(ideal: Drives) -> None:
    """It keeps still where it would push further, and comes back at once."""
    state = controller_start(ideal, PERIOD_S, Q, NONE)
    far = np.concatenate([Q + 1.0, NONE, NONE])
    for _ in range(3):
        force, state = command(ideal, state, Q, NONE, far)
    assert (force == ideal.saturation_n[0]).all()
    assert not state[:5].any()
    state[:5] = 2.0 * ideal.saturation_n[0]
    _, after = command(ideal, state, Q, NONE, np.concatenate([Q - 1e-6, NONE, NONE]))
    assert (after[:5] < state[:5]).all()


def test_encoders_have_steps(drives: Drives) -> None:
    """Positions are rounded, velocities are their differences."""
    assert quantised(np.full(5, 3.4e-6), drives.encoder_step_m) == pytest.approx(np.full(5, 3e-6))
    state = controller_start(drives, PERIOD_S, Q, NONE)
    force, following = command(drives, state, Q + 1.4e-6, np.full(5, 9.0), np.concatenate([Q, NONE, NONE]))
    assert following[5:10] == pytest.approx(Q + 1e-6, abs=1e-12)
    error = -drives.position_gain_per_s * 1e-6 - 1e-6 / PERIOD_S
    assert force == pytest.approx(drives.velocity_gain_nspm * error, rel=1e-6)


def test_commands_are_delayed(ideal: Drives) -> None:
    """By whole periods, each drive by its own."""
    late = replace(ideal, delay_s=np.array([0.0, 1e-3, 2.1e-3, 0.4e-3, 2e-3]))
    state = controller_start(late, PERIOD_S, Q, np.full(5, -1.0))
    seen = []
    for k in range(4):
        force, state = command(late, state, Q, NONE, np.concatenate([Q, NONE, np.full(5, float(k))]))
        seen.append(force)
    assert np.array(seen).T.tolist() == [
        [0.0, 1.0, 2.0, 3.0],
        [-1.0, 0.0, 1.0, 2.0],
        [-1.0, -1.0, 0.0, 1.0],
        [0.0, 1.0, 2.0, 3.0],
        [-1.0, -1.0, 0.0, 1.0],
    ]


def test_what_is_fed_forward(drives: Drives) -> None:
    """The model's force and that of the drive's own mass; friction as far as it is asked for."""
    force, qd, qdd = np.full((1, 5), 7.0), np.full((1, 5), -0.1), np.full((1, 5), 2.0)
    assert feed_forward(drives, force, qd, qdd) == pytest.approx(force + drives.moving_mass_kg * qdd)
    half = replace(drives, force_forward=NONE, friction_forward=np.full(5, 0.5))
    friction = -drives.dry_friction_n - 0.1 * drives.viscous_friction_nspm
    assert feed_forward(half, force, qd, qdd)[0] == pytest.approx(0.5 * friction)
