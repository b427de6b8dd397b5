"""Random machines with random masses at random poses, and how poses follow actuators."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from pipeline.arrays import FloatArray
from pipeline.machine import Machine, forward_kinematics
from pipeline.machine.actuator_space import ActuatorRates, actuator_rates


@dataclass(frozen=True, eq=False)
class Moving:
    """A machine at n poses, moving with random actuator velocities (n, 5)."""

    machine: Machine
    pose: FloatArray
    q_m: FloatArray
    rates: ActuatorRates
    qd_mps: FloatArray

    def at(self, dq_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Close the links for actuators moved by dq (n, 5) or (5,): poses and actuators."""
        q = self.q_m + dq_m
        return forward_kinematics(self.machine, q, self.pose, tolerance_m=1e-12), q


@pytest.fixture(scope="session")
def draw_moving(draw_machine: Callable, draw_poses: Callable) -> Callable[[int, str], Moving]:
    """Draw a machine with any masses, at up to ten of 60 poses with kappa below 30."""

    def draw(seed: int, kind: str) -> Moving:
        rng = np.random.default_rng(seed)
        drawn = draw_machine(seed, kind)
        root = rng.uniform(-0.5, 0.5, (3, 3))
        masses = replace(
            drawn.masses,
            cart_kg=rng.uniform(1.0, 20.0),
            link_kg=rng.uniform(0.5, 3.0, 6),
            platform_centre_m=rng.uniform(-0.1, 0.1, 3),
            platform_inertia_kgm2=root @ root.T + 0.1 * np.eye(3),
            load_kg=rng.uniform(0.0, 10.0),
            gravity_mps2=rng.uniform(-9.0, 9.0, 3),
        )
        machine = replace(drawn, masses=masses)
        sample = draw_poses(machine, seed, count=60, kappa_max=30.0)
        pose, q = sample.pose[:10], sample.q_m[:10]
        return Moving(machine, pose, q, actuator_rates(machine, pose, q[:, :3]), rng.uniform(-0.5, 0.5, q.shape))

    return draw
