"""Inverse dynamics beside an independent multibody simulation: MuJoCo, loops closed by equality constraints."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.machine import Machine, inverse_kinematics
from pipeline.machine.dynamics import inverse_dynamics
from pipeline.machine.geometry import MODES, cart_joints, link_vectors
from pipeline.machine.masses import Masses

mujoco = pytest.importorskip("mujoco")
from tests.machine.multibody import Multibody  # noqa: E402  # needs mujoco

H = 1e-3


@pytest.fixture(scope="module")
def masses(machine: Machine) -> Masses:
    """The reference machine's, with a load."""
    assert machine.masses is not None
    return replace(machine.masses, load_kg=5.0)


def _swing(machine: Machine, t: np.ndarray, seed: int, mode: str) -> tuple[np.ndarray, np.ndarray]:
    """Poses (n, 6) and actuators (n, 5) of a motion from rest in all five controlled coordinates."""
    generator = np.random.default_rng(seed)
    middle = np.array([1.02, 0.3, 0.9, 0.0, 0.0]) + generator.uniform(-0.08, 0.08, 5)
    swing = np.outer((1.0 - np.cos(5.0 * t)) / 2.0, generator.uniform(-0.1, 0.1, 5))
    solution = inverse_kinematics(machine, middle + swing, np.full(len(t), MODES.index(mode)))
    assert solution.reachable.all()
    return solution.pose, solution.q_m


def _ours(machine: Machine, masses: Masses, pose: np.ndarray, q: np.ndarray, h: float) -> object:
    """Forces in the middle of five poses and actuators, derivatives by the same differences."""
    rate = (8.0 * (pose[3] - pose[1]) - (pose[4] - pose[0])) / (12.0 * h)
    acceleration, qdd = ((x[3] - 2.0 * x[2] + x[1]) / h**2 for x in (pose, q))
    return inverse_dynamics(machine, masses, pose[2:3], q[2:3, :3], rate[None], acceleration[None], qdd[None, :3])


@pytest.mark.parametrize("mode", ["LLL", "RRR", "LRR"])
@pytest.mark.parametrize("seed", range(4))
def test_forces_agree_with_the_multibody_model(machine: Machine, masses: Masses, seed: int, mode: str) -> None:
    """Drives and links, in motion, to the accuracy of the differences; whatever each link's tip weighs is added."""
    t = 0.35 + H * np.arange(-2, 3)
    pose, q = _swing(machine, t, seed, mode)
    multibody = Multibody(machine, masses, pose[0], q[0, :3])
    drive, tips = multibody.inverse(np.array([multibody.position(p, a) for p, a in zip(pose, q, strict=True)]), H)
    ours = _ours(machine, masses, pose, q, H)
    assert ours.drive_n[0] == pytest.approx(drive, abs=2e-4 * np.abs(drive).max())
    vectors = link_vectors(machine, pose, q[:, :3])
    joints = cart_joints(machine, q[:, :3]) + vectors
    u = vectors[2] / np.linalg.norm(vectors[2], axis=1, keepdims=True)
    tip_acceleration = (joints[3] - 2.0 * joints[2] + joints[1]) / H**2 - masses.gravity_mps2
    carried = tips + masses.link_kg[:, None] / 2.0 * tip_acceleration
    along = (carried * u).sum(axis=1)
    assert ours.link_n[0] == pytest.approx(along, abs=5e-4 * np.abs(along).max())


def test_driving_the_simulation_with_our_forces_makes_our_motion(machine: Machine, masses: Masses) -> None:
    """Forward in time, without any feedback: after six tenths of a second carts and TCP are where they should be."""
    step = 2e-4
    t = step * np.arange(-2, 3_003)
    pose, q = _swing(machine, t, 3, "LLL")
    multibody = Multibody(machine, masses, pose[2], q[2, :3])
    model, data = multibody.model, multibody.data
    middle = slice(2, -2)
    rate = (pose[3:-1] - pose[1:-3]) / (2.0 * step)
    acceleration, qdd = ((x[3:-1] - 2.0 * x[middle] + x[1:-3]) / step**2 for x in (pose, q))
    forces = inverse_dynamics(machine, masses, pose[middle], q[middle, :3], rate, acceleration, qdd[:, :3]).drive_n
    data.qpos, data.qvel = multibody.position(pose[2], q[2]), 0.0
    for force in forces[:-1]:
        data.qfrc_applied[multibody.driven] = force
        mujoco.mj_step(model, data)
    end = -3
    travel = np.abs(q[end] - q[2])
    assert travel.max() > 0.03
    reached = data.qpos[[model.joint(name).qposadr[0] for name in ("cart0", "cart1", "cart2")]] + multibody.carts0
    assert reached == pytest.approx(q[end, :3], abs=2e-3 * travel.max())
    assert data.qpos[-7:-4] == pytest.approx(pose[end, :3], abs=2e-3 * travel.max())
