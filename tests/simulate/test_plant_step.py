"""A step of the machine: its order, its energy, its friction, and what moves it, against independent computations."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from pipeline.machine import Machine
from pipeline.machine.actuator_space import actuator_rates, mass_matrix
from pipeline.machine.geometry import rotation
from pipeline.machine.kinematics import closure_residual, newton
from pipeline.machine.masses import lumped_platform
from pipeline.simulate import Drives, Motion
from pipeline.simulate.forces import forces_of
from pipeline.simulate.period import start_state
from pipeline.simulate.plant_step import plant_step_function, split_state

AT = 0.3
"""Where along the motion the machine is set moving, as a part of it."""


def moving_state(motion: Motion, force: np.ndarray) -> np.ndarray:
    """Give the state of a machine in the middle of a motion, with drives that push with forces (5,)."""
    row = round(AT * len(motion))
    state = start_state(motion.q_m[row], motion.pose[row], force)
    state[5:10] = motion.qd_mps[row]
    return state


def run(step: ca.Function, state: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Run steps with forces (n, 5). States (n + 1, ...)."""
    after, _ = step.mapaccum("steps", len(forces), ["state"], ["next"])(state, forces.T)
    return np.vstack([state, np.array(after).T])


def energy(machine: Machine, drives: Drives, states: np.ndarray) -> np.ndarray:
    """Kinetic and potential energy at states (n, ...)."""
    at, masses = split_state(states), machine.masses
    assert masses is not None
    M = mass_matrix(machine, actuator_rates(machine, at["pose"], at["q"][:, :3])) + np.diag(drives.moving_mass_kg)
    body = lumped_platform(masses, machine.platform_points_m)
    centre = at["pose"][:, :3] + rotation(*at["pose"][:, 3:].T) @ body.centre_m
    kinetic = np.einsum("ni,nij,nj->n", at["qd"], M, at["qd"]) / 2.0
    return kinetic - body.mass_kg * centre @ masses.gravity_mps2


def test_its_order_is_four(agder: Machine, ideal: Drives, reference: Motion) -> None:
    """Half the step, a sixteenth of the error: over 0.2 s with constant forces."""
    force = reference.drive_n[round(AT * len(reference))]
    ends = []
    for steps in (25, 50, 100, 400):
        step = plant_step_function(agder, ideal, 0.2 / steps)
        ends.append(run(step, moving_state(reference, force), np.tile(force, (steps, 1)))[-1][:16])
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx(4.0, abs=0.35)


def test_energy_is_the_work_of_the_drives(agder: Machine, drives: Drives, reference: Motion) -> None:
    """Less what friction takes, over half a second, to the accuracy of the integral of the latter."""
    smooth = replace(drives, dry_friction_n=np.zeros(5))
    row = round(AT * len(reference))
    forces = reference.drive_n[row : row + 500] + 5.0
    states = run(plant_step_function(agder, smooth, 1e-3), moving_state(reference, forces[0]), forces)
    at = split_state(states)
    work = (forces * np.diff(at["q"], axis=0)).sum()
    speed = at["qd"]
    # Simpson's rule over pairs of steps.
    lost = smooth.viscous_friction_nspm @ (speed[:-2:2] ** 2 + 4.0 * speed[1:-1:2] ** 2 + speed[2::2] ** 2).sum(axis=0)
    gained = np.diff(energy(agder, smooth, states[[0, -1]]))[0]
    assert gained == pytest.approx(work - lost * 1e-3 / 3.0, abs=1e-5)
    assert abs(gained) > 1.0


def test_energy_is_kept(agder: Machine, ideal: Drives, reference: Motion) -> None:
    """Without friction what the drives do is what the machine gains, over half a second."""
    row = round(AT * len(reference))
    forces = reference.drive_n[row : row + 500] + 5.0
    states = run(plant_step_function(agder, ideal, 1e-3), moving_state(reference, forces[0]), forces)
    work = (forces * np.diff(split_state(states)["q"], axis=0)).sum()
    assert np.diff(energy(agder, ideal, states[[0, -1]]))[0] == pytest.approx(work, rel=1e-8)


def test_dry_friction_takes_energy_only(agder: Machine, drives: Drives, reference: Motion) -> None:
    """It is against the motion, at most as large as it may be, and what it takes is missing."""
    forces = np.tile(reference.drive_n[round(AT * len(reference))], (300, 1))
    rough = replace(drives, viscous_friction_nspm=np.zeros(5))
    states = run(plant_step_function(agder, rough, 1e-3), moving_state(reference, forces[0]), forces)
    at = split_state(states)
    moved, grip = np.diff(at["q"], axis=0), at["grip"][1:]
    assert (np.abs(grip) <= rough.dry_friction_n + 1e-12).all()
    assert (grip * moved).sum(axis=0).max() < 0.0
    gained = np.diff(energy(agder, rough, states[[0, -1]]))[0]
    assert gained == pytest.approx((forces * moved).sum() + (grip * moved).sum(), abs=1e-5)


def test_dry_friction_holds_and_lets_go(agder: Machine, drives: Drives, reference: Motion) -> None:
    """With less than friction beside what holds it the machine does not move at all; with more it does."""
    held = reference.drive_n[0]
    start = start_state(reference.q_m[0], reference.pose[0], held)
    step = plant_step_function(agder, drives, 1e-3)
    push = 0.9 * drives.dry_friction_n * np.array([1.0, -1.0, 1.0, 1.0, -1.0])
    still = split_state(run(step, start, np.tile(held + push, (1_000, 1)))[-1])
    assert np.abs(still["q"] - reference.q_m[0]).max() < 1e-6
    assert still["grip"] == pytest.approx(-push, abs=0.1)
    loose = split_state(run(step, start, np.tile(held + 1.5 * push, (300, 1)))[-1])
    assert np.abs(loose["q"] - reference.q_m[0]).max() > 1e-3


def test_forces_are_those_of_inverse_dynamics(agder: Machine, drives: Drives, reference: Motion) -> None:
    """With its accelerations the model's equations give back what the drives push with, less their own share."""
    force = reference.drive_n[round(AT * len(reference))] + np.array([3.0, -2.0, 1.0, 5.0, -4.0])
    smooth = replace(drives, dry_friction_n=np.zeros(5))
    state = moving_state(reference, force)
    qdd = np.array(plant_step_function(agder, smooth, 1e-3)(state, force)[1]).T
    at = split_state(state[None])
    needed = forces_of(agder, at["pose"], at["q"], at["qd"], qdd).drive_n
    own = smooth.moving_mass_kg * qdd + smooth.viscous_friction_nspm * at["qd"]
    assert needed + own == pytest.approx(force[None], abs=1e-8)


def test_forces_lag_behind(agder: Machine, ideal: Drives, reference: Motion) -> None:
    """They approach a new command exponentially, those without lag at once."""
    lag = replace(ideal, force_lag_s=np.array([0.0, 1e-3, 5e-3, 0.0, 2e-3]))
    held = reference.drive_n[0]
    step = plant_step_function(agder, lag, 1e-3)
    states = run(step, start_state(reference.q_m[0], reference.pose[0], held), np.tile(held + 1.0, (3, 1)))
    missing = held + 1.0 - split_state(states)["force"][1:]
    with np.errstate(divide="ignore"):
        expected = np.exp(-np.arange(1, 4)[:, None] * 1e-3 / lag.force_lag_s)
    assert missing == pytest.approx(expected, abs=1e-9)


def test_the_pose_closes_the_links(agder: Machine, drives: Drives, reference: Motion) -> None:
    """Integrated for a quarter of a second it is the pose that Newton's method finds."""
    row = round(AT * len(reference))
    forces = reference.drive_n[row : row + 250]
    last = split_state(run(plant_step_function(agder, drives, 1e-3), moving_state(reference, forces[0]), forces)[-1:])
    assert np.abs(closure_residual(agder, last["pose"], last["q"])).max() < 1e-11
    assert newton(agder, last["q"], last["pose"])[0] == pytest.approx(last["pose"], abs=1e-10)
