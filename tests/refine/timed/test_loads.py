"""Forces in motion and motion of the TCP along q(t / T)."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.machine import Machine
from pipeline.refine import Path, Refinement
from pipeline.refine.timed.first_motion import first_clock, fit_motion
from pipeline.refine.timed.loads import LOADS, limits_loads, load_shares, unloaded_motion_s
from pipeline.retime import measure_usage
from pipeline.retime.own_law import own_time_law

TAU = np.linspace(0.0, 1.0, 2_001)


@pytest.fixture(scope="module")
def motion(machine: Machine, refinement: Refinement) -> Path:
    """Drive a path in eight seconds, with friction and limits of the TCP."""
    assert machine.masses is not None
    masses = replace(machine.masses, friction_n=np.array([20.0, 20.0, 20.0, 30.0, 30.0]))
    limited = replace(machine, masses=masses, tcp_speed_mps=0.6, tcp_acceleration_mps2=1.5)
    path = replace(refinement.path, machine=limited)
    clock = first_clock(path, 30)
    tau = np.linspace(0.0, 1.0, 121)
    return Path(limited, fit_motion(path, clock, 30), tau, path.pose(clock.s_at(tau)), motion_s=8.0)


def test_shares_are_those_that_stage_three_measures(motion: Path) -> None:
    """The largest of every force, of the speed and of the acceleration of the TCP, by other code."""
    shares = load_shares(motion, TAU, 8.0).max(axis=0)
    used = measure_usage(own_time_law(motion, 8.0)).fractions
    expected = np.concatenate([used[name] for name in ("force", "link_force", "tcp_speed", "tcp_acceleration")])
    np.testing.assert_allclose(shares, expected, rtol=5e-3)
    assert len(shares) == len(LOADS)


def test_a_duration_is_lengthened_until_the_limits_are_kept(motion: Path) -> None:
    """One that keeps them stays; gravity does not become less."""
    long = unloaded_motion_s(motion, TAU, 2.0)
    assert load_shares(motion, TAU, 2.0).max() > 1.5
    assert load_shares(motion, TAU, long).max() <= 1.0 + 1e-9
    assert unloaded_motion_s(motion, TAU, long) == long


def test_a_machine_without_masses_and_limits_has_no_loads(machine: Machine, motion: Path) -> None:
    """Forces are then zero, and nothing is limited."""
    bare = replace(machine, masses=None)
    assert limits_loads(machine)
    assert not limits_loads(bare)
    assert load_shares(replace(motion, machine=bare), TAU, 8.0).max() == 0.0
