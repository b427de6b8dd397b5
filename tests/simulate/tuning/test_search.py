"""Tuned gains keep the damping that was asked for, or it is said that none do."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.machine import Machine
from pipeline.simulate import Deviations, Drives, Motion, build_plant, simulate_motion
from pipeline.simulate.tuning import Gains, tune_drives, with_gains
from tests.simulate.motions import backwards, part


def test_gains_are_found_where_usual_ones_are_unstable(agder: Machine, drives: Drives, reference: Motion) -> None:
    """Position gains of 30/s with 2,500 Ns/m are unstable on the way; tuned ones have the damping, there and back."""
    usual = with_gains(drives, Gains(30.0, 4_000.0, 2_500.0, 0.1))
    middle = part(reference, 2_000, 5_000, 100)
    tuning = tune_drives(agder, usual, middle, 0.15)
    assert tuning.before.rightmost_per_s.max() > 1.0
    assert tuning.found
    assert tuning.after.damping.min() >= 0.15
    assert tuning.after.rightmost_per_s.max() < 0.0
    keys = tuning.gains.keys("telescopes")
    assert keys["velocity_gain_nspm"] == tuning.drives.velocity_gain_nspm[3]
    assert tuning.drives.integral_gain_npm == pytest.approx(tuning.drives.velocity_gain_nspm / keys["integral_time_s"])


def test_none_is_said_to_be_found_where_there_is_none(agder: Machine, drives: Drives, reference: Motion) -> None:
    """With forces that come 60 ms late nothing is stable; the nearest gains are given, and are not called found."""
    late = replace(drives, force_lag_s=np.full(5, 0.06))
    tuning = tune_drives(agder, late, part(reference, 4_000, 4_300, 60), 0.3)
    assert not tuning.found
    assert tuning.after.damping.min() < 0.3


def test_tuned_gains_work_in_the_simulation(agder: Machine, drives: Drives, reference: Motion) -> None:
    """Those for the reference motion follow it closer than the assumed ones do."""
    tuned = with_gains(drives, Gains(12.0, 13_000.0, 8_900.0, 0.33))
    plant = build_plant(agder, Deviations())
    back = part(backwards(reference), 0, 1_500)
    errors = [
        np.linalg.norm(simulate_motion(agder, plant, one, back, 0.0).pose_error[:, :3], axis=1).max()
        for one in (drives, tuned)
    ]
    assert errors[1] < errors[0]
