"""Approach poses, and the task between them."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.file import parse_config
from pipeline.errors import ConfigError
from pipeline.limits.actuator_margins import given_poses
from pipeline.limits.approach import approaches, between_approaches

Vary = Callable[[Config, dict[str, object]], Config]
STRAIGHT = {"refine.approach_m": 0.05, "refine.start_direction": [1.0, 2.0, -2.0], "refine.goal_direction": [0, 0, -3]}


def test_approach_poses_are_ahead_of_the_start_and_behind_the_goal(quick_config: Config, vary: Vary) -> None:
    """By the length along the direction, whatever its length; tilt and working mode stay."""
    start, goal = approaches(vary(quick_config, STRAIGHT))
    moved = [start.pose.x_m - start.end.x_m, start.pose.y_m - start.end.y_m, start.pose.z_m - start.end.z_m]
    np.testing.assert_allclose(moved, 0.05 * np.array([1.0, 2.0, -2.0]) / 3.0, atol=1e-12)
    assert goal.pose.z_m == pytest.approx(goal.end.z_m + 0.05)
    assert (goal.pose.mode, goal.pose.x_m, goal.pose.rx_deg) == (goal.end.mode, goal.end.x_m, goal.end.rx_deg)


def test_moves_are_no_longer_than_steps(quick_config: Config, vary: Vary) -> None:
    """A pose in between for every step that the approach is long along an axis."""
    (start,) = approaches(vary(quick_config, {"refine.approach_m": 0.25, "refine.start_direction": [0.0, 1.0, 0.5]}))
    assert start.moves(np.array([0.1, 0.1, 0.1, 1.0, 1.0])) == 3
    assert start.moves(np.array([0.1, 0.5, 0.5, 1.0, 1.0])) == 1


def test_the_planned_task_is_between_the_approach_poses(quick_config: Config, vary: Vary) -> None:
    """An end without a direction stays; without an approach nothing changes."""
    assert between_approaches(quick_config) is quick_config
    config = vary(quick_config, {"refine.approach_m": 0.05, "refine.goal_direction": [0.0, 0.0, -1.0]})
    planned = between_approaches(config)
    assert planned.task.start == config.task.start
    assert planned.task.goal == approaches(config)[0].pose
    assert approaches(planned) == ()
    assert list(given_poses(config)) == ["task.start", "task.goal", "the approach pose of task.goal"]


def test_an_approach_needs_a_direction(quick_config: Config) -> None:
    """The error names the keys to set."""
    raw = quick_config.model_dump(mode="json")
    raw["refine"]["approach_m"] = 0.05
    with pytest.raises(ConfigError, match=r"refine\.approach_m.*start_direction, goal_direction or both"):
        parse_config(raw)
