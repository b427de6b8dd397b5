"""Cones of joints as the machine has them."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.machine import Machine, build_machine
from tests.joints import CONES


def test_cones_are_those_of_the_configuration(agder_config: Config, vary: Callable) -> None:
    """Link by link, with axes of length one, the key they come from, and the joint's name."""
    cones = build_machine(vary(agder_config, CONES).machine).joint_cones
    assert [one.key for one in cones] == list(CONES)
    assert [one.joint for one in cones[1:3]] == ["platform joint of link 2b", "cart joint of link 3a"]
    assert [(one.link, one.at_platform, one.half_angle_deg) for one in cones[1:3]] == [
        (2, True, 105.0),
        (3, False, 52.0),
    ]
    for one in cones:
        assert np.linalg.norm(one.axis) == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(cones[0].axis, cones[1].axis, atol=1e-15)


def test_without_cones_there_are_none(machine: Machine) -> None:
    """Joints turn as far as they like."""
    assert machine.joint_cones == ()


@pytest.mark.parametrize("size", [1e-300, 1e-12, 20.0])
def test_axes_are_of_any_length(agder_config: Config, vary: Callable, size: float) -> None:
    """Directions of tiny or large numbers are the same."""
    changes = {"machine.links.l3c.platform_cone": {"axis": [size, 0.0, -size], "half_angle_deg": 1.0}}
    (one,) = build_machine(vary(agder_config, changes).machine).joint_cones
    np.testing.assert_allclose(one.axis, [np.sqrt(0.5), 0.0, -np.sqrt(0.5)], rtol=1e-15)
