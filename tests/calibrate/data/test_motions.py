"""A driven motion, and measurements of it: what encoders showed depends on the clock of the tracker."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.calibrate import DrivenMotion, StaticPoses, StaticSetting, simulate_motion, simulate_static
from pipeline.calibrate.data.poses import Timing
from pipeline.config import Config
from pipeline.machine.actuator_space.controller_units import ControllerUnits
from tests.calibrate.conftest import MOTION_S, REFLECTORS_M

T = np.linspace(-0.1, MOTION_S + 0.1, 63)


def test_rates_are_those_of_the_encoders(driven: DrivenMotion) -> None:
    """Rates agree with central differences, in the units of the controller; before and after the machine is at rest."""
    units = ControllerUnits(np.full(5, 1.0), np.full(5, 2e-3), np.array([1.0, 1.001, 0.999, 1.0, 1.002]))
    own, h = replace(driven, units=units), 1e-5
    differences = (own.encoders(T + h) - own.encoders(T - h)) / (2.0 * h)
    assert own.encoder_rates(T) == pytest.approx(differences, abs=1e-6)
    assert (own.encoder_rates(T)[[0, -1]] == 0.0).all()
    assert units.to_geometry(own.encoders(T)) == pytest.approx(driven.trajectory.q(T), abs=1e-14)


def test_rows_of_a_motion_follow_its_clock(driven: DrivenMotion) -> None:
    """Static rows keep their encoders; those of every motion are where the controller was by its own clock."""
    q, motion = np.zeros((4, 5)), np.array([-1, 0, 1, 1])
    poses = StaticPoses(q, np.zeros((4, 2, 3)), timing=Timing(driven, motion, np.array([np.nan, 1.0, 1.0, 2.0])))
    assert poses.motions == 2
    found = poses.encoders(np.array([0.25, -0.5]))
    assert (found[0] == 0.0).all()
    assert found[1:] == pytest.approx(driven.encoders(np.array([0.75, 1.5, 2.5])))
    assert (poses.encoder_rates(np.array([0.25, -0.5]))[0] == 0.0).all()
    picked = poses.at(np.array([3, 0]))
    assert picked.encoders(np.array([0.25, -0.5])) == pytest.approx(found[[3, 0]])


def test_static_poses_and_motions_of_a_seed_are_of_one_machine(quick_config: Config, driven: DrivenMotion) -> None:
    """The machine, its tracker and reflectors are drawn alike."""
    setting = StaticSetting(poses=5, seed=3)
    still = simulate_static(quick_config, REFLECTORS_M[:2], setting).truth
    moving = simulate_motion(quick_config, REFLECTORS_M[:2], driven, setting, 0.01).truth
    assert moving.values() == pytest.approx(np.insert(still.values(), -6, 0.01))
    assert (moving.rotation == still.rotation).all()
