"""The five equations against a multibody program that knows nothing of them."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.machine import Machine
from pipeline.simulate import Deviations, Drives, Motion, build_plant, simulate_motion
from tests.simulate.motions import part


def difference_m(machine: Machine, plant_machine: Machine, drives: Drives, motion: Motion) -> tuple[float, float]:
    """Largest distance between the TCPs of both simulations, and how far they are from the command."""
    from tests.simulate.mujoco_twin import follow_in_mujoco

    plant = replace(build_plant(machine, Deviations()), machine=plant_machine)
    simulation = simulate_motion(machine, plant, drives, motion, standing_s=0.0)
    _, xyz = follow_in_mujoco(plant.machine, drives, motion)
    off = np.linalg.norm(simulation.pose[:, :3] - xyz, axis=1).max()
    return float(off), float(np.linalg.norm(simulation.pose_error[:, :3], axis=1).max())


@pytest.mark.parametrize("friction", ["viscous", "dry"])
def test_mujoco_agrees(agder: Machine, drives: Drives, reference: Motion, friction: str) -> None:
    """Within two micrometres, where heavier masses, motors and friction put the TCP hundreds off."""
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    exact = replace(drives, encoder_step_m=np.zeros(5), integral_gain_npm=np.zeros(5))
    exact = exact if friction == "dry" else replace(exact, dry_friction_n=np.zeros(5))
    heavier = build_plant(agder, Deviations(mass_error=0.05)).machine
    # Without integrals, both begin with the forces that are fed forward.
    off, error = difference_m(agder, heavier, exact, part(reference, 0, 600))
    assert error > 1e-4
    assert off < 2e-6
