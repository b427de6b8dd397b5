"""Inverse dynamics: energy, virtual work, Newton's law for the whole machine, and what each part weighs."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.config import DynamicsConfig
from pipeline.machine import Machine, forward_kinematics, inverse_kinematics
from pipeline.machine.dynamics import angular_motion, carried_cart_masses, inverse_dynamics
from pipeline.machine.geometry import ARM_OF_LINK, cart_joints, link_vectors, rotation
from pipeline.machine.masses import Masses, build_masses, lumped_platform

CONTROLLED = np.array(
    [
        [1.02, 0.30, 0.90, 0.10, -0.20],
        [1.30, 0.45, 0.75, 0.15, -0.10],
        [1.10, 0.60, 0.80, -0.10, 0.20],
        [0.80, 0.35, 1.00, 0.30, 0.10],
        [1.00, 0.25, 0.80, -0.25, -0.15],
    ]
)


@pytest.fixture(scope="module")
def masses(machine: Machine) -> Masses:
    """The reference machine's, with a load and without friction."""
    assert machine.masses is not None
    return replace(machine.masses, load_kg=7.0)


def _motion(machine: Machine, t: np.ndarray, start: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Poses (n, 6) and actuators (n, 5) of a motion that swings all five controlled coordinates."""
    generator = np.random.default_rng(seed)
    swing = generator.uniform(0.02, 0.06, 5) * np.sin(np.outer(t, generator.uniform(1.0, 4.0, 5)) + 1.0)
    solution = inverse_kinematics(machine, start + swing, np.zeros(len(t), dtype=np.int64))
    assert solution.reachable.all()
    return solution.pose, solution.q_m


def _energy(machine: Machine, masses: Masses, pose: np.ndarray, q: np.ndarray, h: float) -> np.ndarray:
    """Kinetic and potential energy, point by point and without a rigid body: every mass by its own velocity.

    The platform's own inertia is made of six points on its principal axes.
    """
    R = rotation(pose[:, 3], pose[:, 4], pose[:, 5])
    moments = np.diag(masses.platform_inertia_kgm2)
    radii = np.sqrt((moments.sum() / 2.0 - moments) / (2.0 * masses.platform_kg / 6.0))
    body = np.concatenate([radii * np.eye(3), -radii * np.eye(3)]) + masses.platform_centre_m
    points = [(masses.platform_kg / 6.0, pose[:, :3] + R @ point) for point in body]
    points.append((masses.load_kg, pose[:, :3]))
    joints = cart_joints(machine, q[:, :3])
    platform_joints = joints + link_vectors(machine, pose, q[:, :3])
    for link, mass in enumerate(masses.link_kg):
        points += [(mass / 2.0, joints[:, link]), (mass / 2.0, platform_joints[:, link])]
    points += [(masses.cart_kg, q[:, [k]] * [1.0, 0.0, 0.0]) for k in range(3)]
    energy = np.zeros(len(pose) - 2)
    for mass, path in points:
        velocity = (path[2:] - path[:-2]) / (2.0 * h)
        energy += mass * ((velocity**2).sum(axis=1) / 2.0 - path[1:-1] @ masses.gravity_mps2)
    return energy


@pytest.mark.parametrize("seed", range(5))
def test_the_power_of_the_drives_is_the_change_of_energy(machine: Machine, masses: Masses, seed: int) -> None:
    """F . qd = d(T + V)/dt, with T and V summed over points and derivatives by differences, to their accuracy."""
    h = 1e-4
    t = np.arange(-3, 4) * h
    pose, q = _motion(machine, t, CONTROLLED[seed], seed)
    energy = _energy(machine, masses, pose, q, h)
    power = (energy[3] - energy[1]) / (2.0 * h)
    rate, qd = ((x[4] - x[2]) / (2.0 * h) for x in (pose, q))
    acceleration, qdd = ((x[4] - 2.0 * x[3] + x[2]) / h**2 for x in (pose, q))
    forces = inverse_dynamics(machine, masses, pose[3:4], q[3:4, :3], rate[None], acceleration[None], qdd[None, :3])
    assert forces.drive_n[0] @ qd == pytest.approx(power, abs=1e-4 * np.abs(forces.drive_n[0] * qd).sum())


@pytest.mark.parametrize("row", range(5))
def test_forces_at_rest_are_the_slope_of_potential_energy(machine: Machine, masses: Masses, row: int) -> None:
    """Virtual work: moving one actuator by dq, the others held, raises the potential energy by F dq."""
    pose, q = _motion(machine, np.zeros(1), CONTROLLED[row], row)
    still, step = np.zeros((1, 6)), 1e-6
    forces = inverse_dynamics(machine, masses, pose, q[:, :3], still, still, np.zeros((1, 3)))
    moved = q + step * np.concatenate([np.eye(5), -np.eye(5)])
    poses = forward_kinematics(machine, moved, np.broadcast_to(pose, (10, 6)))
    body = lumped_platform(masses, machine.platform_points_m)
    centre = poses[:, :3] + rotation(poses[:, 3], poses[:, 4], poses[:, 5]) @ body.centre_m
    potential = -body.mass_kg * centre @ masses.gravity_mps2
    assert forces.drive_n[0] == pytest.approx((potential[:5] - potential[5:]) / (2.0 * step), abs=1e-4)


def test_everything_that_is_accelerated_along_the_rails_is_pushed_by_the_carts(
    machine: Machine, masses: Masses
) -> None:
    """Moving as one block along X at 1 m/s^2, the carts' forces sum up to the mass of all of it."""
    pose, q = _motion(machine, np.zeros(3), CONTROLLED[0], 1)
    still, along = np.zeros((3, 6)), np.eye(6)[[0]] * np.ones((3, 1))
    forces = inverse_dynamics(machine, masses, pose, q[:, :3], still, along, np.ones((3, 3)))
    whole = 3.0 * masses.cart_kg + masses.link_kg.sum() + masses.platform_kg + masses.load_kg
    assert forces.drive_n[:, :3].sum(axis=1) == pytest.approx(whole)


def test_links_carry_the_platform(machine: Machine, masses: Masses) -> None:
    """At rest the links' forces sum up to the weight of the platform, the load and half of every link."""
    pose, q = _motion(machine, np.zeros(1), CONTROLLED[1], 2)
    still = np.zeros((1, 6))
    forces = inverse_dynamics(machine, masses, pose, q[:, :3], still, still, np.zeros((1, 3)))
    vectors = link_vectors(machine, pose, q[:, :3])
    u = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    weight = 9.81 * (masses.platform_kg + masses.load_kg + masses.link_kg.sum() / 2.0)
    assert (forces.link_n[..., None] * u).sum(axis=1)[0] == pytest.approx([0.0, 0.0, weight], abs=1e-9)


@given(speed=st.floats(0.1, 10.0), push=st.floats(-5.0, 5.0))
def test_forces_are_quadratic_in_speed_and_linear_in_acceleration(machine: Machine, speed: float, push: float) -> None:
    """On the same curve, F = a sdd + b sd^2 + c with the same a, b, c for all speeds."""
    masses = machine.masses
    h = 1e-4
    pose, q = _motion(machine, np.arange(-1, 2) * h, CONTROLLED[2], 3)
    first, q1 = ((x[2] - x[0]) / (2.0 * h) for x in (pose, q))
    second, q2 = ((x[2] - 2.0 * x[1] + x[0]) / h**2 for x in (pose, q))

    def drive(sd: float, sdd: float) -> np.ndarray:
        motion = (first * sd, second * sd**2 + first * sdd, (q2 * sd**2 + q1 * sdd)[:3])
        return inverse_dynamics(machine, masses, pose[1:2], q[1:2, :3], *(part[None] for part in motion)).drive_n[0]

    c = drive(0.0, 0.0)
    a, b = drive(0.0, 1.0) - c, drive(1.0, 0.0) - c
    assert drive(speed, push) == pytest.approx(a * push + b * speed**2 + c, rel=1e-9, abs=1e-7)


def test_angular_velocity_and_acceleration_are_those_of_the_rotation() -> None:
    """[omega x] = dR/dt R', and alpha its derivative, by differences of R along a turning motion."""
    h = 1e-4
    t = np.arange(-3, 4)[:, None] * h
    angles = np.array([0.3, -0.7, 0.5]) + t * [1.0, -2.0, 0.5] + t**2 * [0.3, 0.8, -1.1]
    R = rotation(*angles.T)
    spin = (R[2:] - R[:-2]) / (2.0 * h) @ np.swapaxes(R[1:-1], -1, -2)
    omega = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
    pose = np.concatenate([np.zeros((7, 3)), angles], axis=1)[[3]]
    rate, acceleration = np.zeros((1, 6)), np.zeros((1, 6))
    rate[0, 3:], acceleration[0, 3:] = [1.0, -2.0, 0.5], [0.6, 1.6, -2.2]
    found, alpha = angular_motion(pose, rate, acceleration)
    assert found[0] == pytest.approx(omega[2], abs=1e-6)
    assert alpha[0] == pytest.approx((omega[3] - omega[1]) / (2.0 * h), abs=1e-5)


def test_masses_are_lumped_without_losing_any(machine: Machine, masses: Masses) -> None:
    """Carts and lumped platform weigh together what the machine weighs; a single body stays what it is."""
    body = lumped_platform(masses, machine.platform_points_m)
    total = body.mass_kg + carried_cart_masses(masses).sum()
    assert total == pytest.approx(3.0 * 12.0 + 4 * 1.2 + 2 * 1.8 + 15.0 + 7.0)
    assert np.bincount(ARM_OF_LINK).tolist() == [1, 2, 3]
    alone = lumped_platform(replace(masses, load_kg=0.0, link_kg=np.zeros(6)), machine.platform_points_m)
    assert alone.mass_kg == masses.platform_kg
    assert alone.centre_m == pytest.approx(masses.platform_centre_m)
    assert alone.inertia_kgm2 == pytest.approx(masses.platform_inertia_kgm2)


def test_masses_come_from_the_configuration(agder_config) -> None:
    """Every key arrives where it belongs; gravity is downwards, friction by kind of actuator."""
    config = agder_config.machine.dynamics
    changed = DynamicsConfig(**{**config.model_dump(), "load_kg": 2.0, "friction": {"carts_n": 5.0}})
    built = build_masses(changed)
    assert built.link_kg.tolist() == [1.2, 1.2, 1.8, 1.2, 1.8, 1.2]
    assert built.load_kg == 2.0
    assert built.gravity_mps2.tolist() == [0.0, 0.0, -9.81]
    assert built.friction_n.tolist() == [5.0, 5.0, 5.0, 0.0, 0.0]
