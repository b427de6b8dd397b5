"""Frozen-time poles: known answers, and what the simulation itself does with small deviations."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.arrays import FloatArray
from pipeline.machine import Machine
from pipeline.machine.actuator_space import actuator_rates, gravity_stiffness, least_stiffness
from pipeline.simulate import Deviations, Drives, Motion, build_plant, simulate_motion
from pipeline.simulate.tuning import Linearised, linearised, loop_poles, sampled_machine
from tests.simulate.motions import standing

PERIOD_S = 1e-4


def single_mass(mass_kg: float) -> Linearised:
    """Five masses on their own."""
    none = np.zeros((1, 5, 5))
    return Linearised(np.zeros(1), mass_kg * np.eye(5)[None], none, none)


def _stiffness_npm(machine: Machine, motion: Motion) -> FloatArray:
    """Compute the least stiffness by gravity at every row."""
    return least_stiffness(gravity_stiffness(machine, actuator_rates(machine, motion.pose, motion.q_m[:, :3])))


def test_a_mass_under_p_over_v(ideal: Drives) -> None:
    """With m s^2 + kv s + kv kp = 0: damping sqrt(kv / (m kp)) / 2, up to the short period."""
    kv, kp, mass = 2_000.0, 20.0, 250.0
    plain = replace(
        ideal,
        velocity_gain_nspm=np.full(5, kv),
        position_gain_per_s=np.full(5, kp),
        integral_gain_npm=np.zeros(5),
    )
    poles = loop_poles(sampled_machine(single_mass(mass), plain, PERIOD_S), plain)
    assert poles.damping[0] == pytest.approx(np.sqrt(kv / (mass * kp)) / 2.0, rel=1e-2)
    assert poles.rightmost_per_s[0] == pytest.approx(-kv / (2.0 * mass), rel=1e-2)


def test_gravity_lag_and_delay_cost_damping(ideal: Drives) -> None:
    """Each of them less than without, and together enough to make a loop unstable."""
    free = single_mass(10.0)
    falling = replace(free, stiffness=-20_000.0 * np.eye(5)[None])
    late = replace(ideal, delay_s=np.full(5, 2e-3))
    lagging = replace(ideal, force_lag_s=np.full(5, 5e-3))
    damping = [
        loop_poles(sampled_machine(linear, drives, 1e-3), drives).damping[0]
        for linear, drives in ((free, ideal), (falling, ideal), (free, late), (free, lagging))
    ]
    assert damping[0] == max(damping)
    both = replace(lagging, delay_s=np.full(5, 5e-3))
    assert loop_poles(sampled_machine(falling, both, 1e-3), both).damping[0] < 0.0


def test_encoders_cost_half_a_period(ideal: Drives) -> None:
    """The velocity that is differenced is half a period old: less damping where sampling matters."""
    stepped = replace(ideal, encoder_step_m=np.full(5, 1e-6))
    exact, old = (loop_poles(sampled_machine(single_mass(8.0), one, 1e-3), one).damping[0] for one in (ideal, stepped))
    assert old < exact


def test_deviations_die_out_as_the_poles_say(agder: Machine, ideal: Drives, reference: Motion) -> None:
    """Standing where gravity is against it, a push grows or decays with the rightmost pole."""
    row = int(np.argmin(_stiffness_npm(agder, reference)))
    weak = replace(
        ideal,
        position_gain_per_s=np.array([10.0, 10.0, 10.0, 12.0, 12.0]),
        velocity_gain_nspm=np.array([8_000.0, 8_000.0, 8_000.0, 600.0, 600.0]),
        integral_gain_npm=np.zeros(5),
        trip_m=np.full(5, 1.0),
    )
    still = standing(agder, reference.q_m[row], reference.pose[row], 3.0)
    expected = loop_poles(sampled_machine(linearised(agder, still, np.zeros(1, dtype=int)), weak, 1e-3), weak)
    assert expected.rightmost_per_s[0] > 0.5
    pushed = replace(still, middle_n=still.middle_n + np.array([0.0, 0.0, 0.0, 1e-3, 1e-3]))
    simulation = simulate_motion(agder, build_plant(agder, Deviations()), weak, pushed, standing_s=0.0)
    speed = np.abs(simulation.qd_mps[:, 4])
    assert np.log(speed[2_900] / speed[2_400]) / 0.5 == pytest.approx(expected.rightmost_per_s[0], rel=0.05)


def test_the_way_back_has_other_poles(agder: Machine, drives: Drives, reference: Motion) -> None:
    """There and back share masses and stiffness, and the forces of velocities change their sign."""
    worst = int(np.argmin(_stiffness_npm(agder, reference)))
    linear = linearised(agder, reference, np.array([worst // 2, worst]))
    both = linear.both_ways()
    assert (both.damping[2:] == -linear.damping).all()
    poles = loop_poles(sampled_machine(both, drives, 1e-3), drives)
    assert poles.damping[1] != pytest.approx(poles.damping[3], rel=1e-3)
