"""What the drives feel along a motion."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.machine.dynamics import carried_cart_masses
from pipeline.machine.masses import lumped_platform
from pipeline.retime import measure_drives, slowed
from pipeline.retime.fastest import plan


def test_a_machine_that_moves_as_one_block_stays_as_it_is(line) -> None:
    """Along X with all carts alike nothing that the drives feel changes, and there is no damping."""
    drives = measure_drives(plan(line(0.5), 300))
    assert drives.felt is not None
    assert np.ptp(drives.felt.reflected_mass_kg, axis=0) == pytest.approx(np.zeros(5), abs=1e-6)
    assert drives.felt.damping_nspm.value == pytest.approx(0.0, abs=1e-6)
    machine = line(0.5).machine
    whole = carried_cart_masses(machine.masses).sum()
    whole += lumped_platform(machine.masses, machine.platform_points_m).mass_kg
    # Along (1, 1, 1, 0, 0) / sqrt(3) the drives move all of it.
    assert (drives.felt.worst_mass_kg.value > whole / 3.0).all()


def test_damping_is_proportional_to_speed(path) -> None:
    """Half as fast, half of it; masses, stiffness and amplification are those of the poses."""
    fast, slow = (measure_drives(slowed(plan(path, 300), speed)) for speed in (1.0, 0.5))
    assert fast.felt is not None
    assert slow.felt is not None
    assert slow.felt.damping_nspm.value == pytest.approx(fast.felt.damping_nspm.value / 2.0, abs=1e-6)
    np.testing.assert_allclose(slow.felt.stiffness_npm.value, fast.felt.stiffness_npm.value, rtol=1e-6, atol=1e-4)
    np.testing.assert_allclose(slow.amplified.angle.value, fast.amplified.angle.value, rtol=1e-6)
    assert slow.t_s[-1] == pytest.approx(2.0 * fast.t_s[-1])


def test_without_masses_there_is_amplification_alone(path) -> None:
    """What needs masses is left out."""
    trajectory = plan(path, 300)
    drives = measure_drives(replace(trajectory, path=replace(path, machine=replace(path.machine, masses=None))))
    assert drives.felt is None
    assert (drives.amplified.position.value > 0.0).all()
