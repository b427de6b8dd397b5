"""The twin as a whole: what ideal and real drives make of a motion, and how it ends."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.errors import ArgumentError, UsageError
from pipeline.machine import Machine, forward_kinematics
from pipeline.simulate import Deviations, Drives, Ending, Motion, build_plant, simulate_motion
from tests.simulate.motions import backwards, part, standing

HELD_Q_M = np.array([1.267975156, 1.889507496, 0.563389632, 1.083873253, 1.216756452])
HELD_POSE = np.array([1.000839, 0.737479, 0.842738, -0.362649, 0.224377, -0.421218])
"""Where gravity makes a motion of the reference machine least stable, near 4.16 s, in actuators and pose."""


@pytest.mark.parametrize("way", ["there", "back"])
def test_ideal_drives_follow(agder: Machine, ideal: Drives, reference: Motion, way: str) -> None:
    """Within 0.01 mm at the TCP, with the planned forces and modes, there and back."""
    motion = reference if way == "there" else backwards(reference)
    simulation = simulate_motion(agder, build_plant(agder, Deviations()), ideal, motion)
    assert simulation.verdict.ending == Ending.ARRIVED
    assert len(simulation) == len(motion)
    assert np.linalg.norm(simulation.pose_error[:, :3], axis=1).max() < 1e-5
    assert np.abs(simulation.following_error_m).max() < 1e-5
    assert np.abs(simulation.drive_n - motion.middle_n).max() < 5.0
    assert (simulation.det_h / simulation.planned_det_h).min() > 0.999


def test_what_the_model_does_not_know_shows(agder: Machine, ideal: Drives, reference: Motion) -> None:
    """Masses and loads as errors of following, geometry as errors of the pose even where drives follow exactly."""
    short = part(reference, 0, 500)
    simulations = {
        name: simulate_motion(agder, build_plant(agder, deviations), ideal, short, standing_s=0.2)
        for name, deviations in (
            ("none", Deviations()),
            ("mass", Deviations(mass_error=0.05)),
            ("load", Deviations(load_kg=5.0)),
            ("geometry", Deviations(geometry_std_m=2e-4, seed=3)),
        )
    }
    following = {name: np.abs(one.following_error_m).max() for name, one in simulations.items()}
    assert following["none"] < 1e-6 < following["mass"] < following["load"]
    pose = {name: np.linalg.norm(one.pose_error[:, :3], axis=1).min() for name, one in simulations.items()}
    assert pose["geometry"] > 1e-4 > pose["load"]


def test_it_starts_where_the_real_machine_is(agder: Machine, ideal: Drives, reference: Motion) -> None:
    """At rest, held by its integrals, with its actuators as commanded: nothing moves before the motion."""
    plant = build_plant(agder, Deviations(geometry_std_m=5e-4, seed=1, mass_error=0.1, load_kg=3.0))
    still = standing(agder, reference.q_m[0], reference.pose[0], 0.5)
    simulation = simulate_motion(agder, plant, ideal, still)
    q = still.q_m[:1] + plant.offsets_m
    expected = forward_kinematics(plant.machine, q, reference.pose[0])
    assert np.abs(simulation.pose - expected).max() < 1e-9
    assert np.abs(simulation.following_error_m).max() < 1e-10


def test_the_same_seed_is_the_same_machine(agder: Machine) -> None:
    """And another seed another one; it is the machine that a simulated measurement draws."""
    one, same, other = (build_plant(agder, Deviations(2e-4, seed)) for seed in (4, 4, 5))
    assert (one.machine.rails_m == same.machine.rails_m).all()
    assert (one.zeros_m == same.zeros_m).all()
    assert (one.machine.rails_m != other.machine.rails_m).any()


def test_gravity_asks_for_stiffness(agder: Machine, ideal: Drives) -> None:
    """Standing at 4.16 s of the reference motion: telescopes of 9 kN/m hold a push of 1 N, those of 8 kN/m do not."""
    far = {}
    for stiffness in (8_000.0, 9_000.0):
        kv = np.array([8_000.0, 8_000.0, 8_000.0, 300.0, 300.0])
        kp = np.where(np.arange(5) < 3, 10.0, stiffness / kv)
        gains = {"position_gain_per_s": kp, "velocity_gain_nspm": kv, "integral_gain_npm": np.zeros(5)}
        weak = replace(ideal, **gains, trip_m=np.full(5, 1.0))
        still = standing(agder, HELD_Q_M, forward_kinematics(agder, HELD_Q_M[None], HELD_POSE)[0], 6.0)
        pushed = replace(still, middle_n=still.middle_n + np.array([0.0, 0.0, 0.0, 0.53, 0.83]))
        simulation = simulate_motion(agder, build_plant(agder, Deviations()), weak, pushed, standing_s=0.01)
        far[stiffness] = np.abs(simulation.following_error_m[-1]).max()
    assert far[9_000.0] < 2e-3 < 5e-3 < far[8_000.0]


def test_a_drive_trips(agder: Machine, ideal: Drives, reference: Motion) -> None:
    """Where its following error is too large: the motion ends there, with drive, error and time."""
    weak = replace(ideal, force_forward=np.zeros(5), position_gain_per_s=np.full(5, 0.5), trip_m=np.full(5, 2e-3))
    simulation = simulate_motion(agder, build_plant(agder, Deviations()), weak, reference)
    verdict = simulation.verdict
    assert verdict.ending == Ending.TRIPPED
    assert not verdict.arrived
    assert simulation.t_s[-1] == pytest.approx(verdict.t_s)
    last = np.abs(simulation.following_error_m[-1])
    assert "trips: its following error is" in verdict.reason
    assert (last > 2e-3).any()
    assert (np.abs(simulation.following_error_m[:-1]) <= 2e-3).all()


def test_a_machine_is_lost(agder: Machine, ideal: Drives, reference: Motion) -> None:
    """Without stiffness and trips it falls: into an end stop, or through a singularity."""
    weak = replace(
        ideal,
        position_gain_per_s=np.full(5, 1e-3),
        velocity_gain_nspm=np.full(5, 10.0),
        integral_gain_npm=np.zeros(5),
        trip_m=np.full(5, 10.0),
    )
    plant = build_plant(agder, Deviations(load_kg=5.0))
    simulation = simulate_motion(agder, plant, weak, reference)
    assert simulation.verdict.ending == Ending.LOST
    assert "end stop" in simulation.verdict.reason or "singularity" in simulation.verdict.reason
    assert np.isfinite(simulation.pose).all()
    assert 1 <= len(simulation) < len(reference)


def test_a_machine_that_stands_elsewhere_is_told(agder: Machine, ideal: Drives, reference: Motion) -> None:
    """Drives that follow by far too slowly are still on their way at the end."""
    slow = replace(ideal, velocity_forward=np.zeros(5), position_gain_per_s=np.full(5, 0.8), trip_m=np.full(5, 1.0))
    short = part(reference, 0, 600)
    simulation = simulate_motion(agder, build_plant(agder, Deviations()), slow, short, standing_s=0.2)
    assert simulation.verdict.ending == Ending.ELSEWHERE
    assert "mm" in simulation.verdict.reason


def test_controllers_at_a_longer_period(agder: Machine, ideal: Drives, reference: Motion) -> None:
    """The machine is integrated in finer steps than the controllers run at, with the command held."""
    every = replace(
        part(reference, 0, 401),
        period_s=4e-3,
        **{
            name: getattr(part(reference, 0, 401), name)[::4]
            for name in ("t_s", "q_m", "qd_mps", "qdd_mps2", "pose", "drive_n", "link_n")
        },
        **{name: getattr(reference, name)[2:403:4] for name in ("middle_n", "middle_mps", "middle_mps2")},
    )
    gentle = replace(ideal, velocity_gain_nspm=np.full(5, 1_000.0), integral_gain_npm=np.zeros(5))
    simulation = simulate_motion(agder, build_plant(agder, Deviations()), gentle, every, standing_s=0.0)
    assert np.linalg.norm(simulation.pose_error[:, :3], axis=1).max() < 1e-4


def test_machines_without_masses_and_impossible_ones_are_refused(agder: Machine) -> None:
    """Each with what is wrong."""
    with pytest.raises(UsageError, match=r"machine\.dynamics"):
        build_plant(replace(agder, masses=None), Deviations())
    for wrong in ({"mass_error": -1.0}, {"load_kg": -1.0}, {"geometry_std_m": np.nan}, {"seed": 1.5}):
        with pytest.raises(ArgumentError, match=next(iter(wrong))):
            Deviations(**wrong)
