"""Drives as arrays."""

from dataclasses import replace

import numpy as np

from pipeline.config.file import parse_config
from pipeline.machine import Machine
from pipeline.simulate import Drives, build_drives
from tests.config.test_config import with_value


def test_friction_is_the_machines_unless_it_is_given(agder: Machine) -> None:
    """Then that of `machine.dynamics.friction`, and where there is none what is assumed."""
    assert agder.masses is not None
    rough = replace(agder, masses=replace(agder.masses, friction_n=np.array([7.0, 7.0, 7.0, 0.0, 0.0])))
    config = parse_config(with_value("drives.carts.c1.dry_friction_n", 0.0)).drives
    assert build_drives(config, rough).dry_friction_n.tolist() == [0.0, 7.0, 7.0, 40.0, 40.0]


def test_saturation_is_the_limit_of_force_unless_it_is_given(agder: Machine) -> None:
    """Push and pull each by itself."""
    config = parse_config(with_value("drives.telescopes.l3b.saturation_n", {"push": 100.0, "pull": 200.0})).drives
    built = build_drives(config, agder)
    assert built.saturation_n[:, 4].tolist() == [100.0, 200.0]
    assert (built.saturation_n[:, :4] == agder.force_limits_n[:, :4]).all()


def test_integrals_follow_from_their_times(drives: Drives, agder: Machine) -> None:
    """They are kv / Tn, and none where there is no time."""
    assert np.allclose(drives.integral_gain_npm, drives.velocity_gain_nspm / 0.3)
    config = parse_config(with_value("drives.carts.integral_time_s", None)).drives
    assert build_drives(config, agder).integral_gain_npm[:3].tolist() == [0.0] * 3
