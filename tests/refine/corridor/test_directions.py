"""Directions at the ends, from the TCP to the actuators."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.errors import ConfigError
from pipeline.machine import Machine
from pipeline.refine import pose_derivatives, refine_path
from pipeline.refine.corridor.directions import end_directions
from pipeline.route import Route


def _with(config: Config, **keys: object) -> Config:
    return config.model_copy(update={"refine": config.refine.model_copy(update=keys)})


def test_ends_without_a_direction_are_free(light_config: Config, machine: Machine, route: Route) -> None:
    """NaN stands for any direction."""
    assert np.isnan(end_directions(light_config, machine, route)).all()


def test_actuators_along_x_are_the_carts_alone(light_config: Config, machine: Machine, route: Route) -> None:
    """Along the rails all carts go together, and telescopes stay as they are."""
    found = end_directions(_with(light_config, goal_direction=(-2.0, 0.0, 0.0)), machine, route)
    np.testing.assert_allclose(found[1], np.array([-1.0, -1.0, -1.0, 0.0, 0.0]) / np.sqrt(3.0), atol=1e-9)


@pytest.mark.parametrize("direction", [(0.0, 0.0, -1.0), (0.3, 0.5, -0.4), (0.0, 1.0, 0.0)])
def test_a_path_leaves_and_arrives_as_configured(
    light_config: Config, machine: Machine, route: Route, direction: tuple[float, float, float]
) -> None:
    """The TCP moves along the direction and the platform does not tilt, at both ends, whatever is minimised."""
    config = _with(light_config, start_direction=direction, goal_direction=direction)
    path = refine_path(config, machine, route).path
    _, speed, _, _ = pose_derivatives(path, np.array([0.0, 1.0]))
    unit = np.array(direction) / np.linalg.norm(direction)
    for row in speed:
        along = row[:3] @ unit
        assert along > 0.0
        np.testing.assert_allclose(row[:3], along * unit, atol=1e-6 * along)
        np.testing.assert_allclose(row[[3, 5]], 0.0, atol=1e-6 * along)


def test_a_direction_at_a_serial_singularity_is_refused(light_config: Config, machine: Machine, route: Route) -> None:
    """Where an arm is at right angles to its rail its cart cannot move the TCP across it."""
    gate = int(np.flatnonzero(route.gates)[0])
    rest = replace(route, pose=route.pose[gate:], q_m=route.q_m[gate:])
    with pytest.raises(ConfigError, match="start_direction"):
        end_directions(_with(light_config, start_direction=(0.0, 0.0, 1.0)), machine, rest)
