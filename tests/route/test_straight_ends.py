"""Straight ends of routes."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.errors import ConfigError
from pipeline.machine import Machine
from pipeline.route import build_regions, plan_route
from pipeline.route.metric import arc_length, step_sizes
from pipeline.route.regions.counting import require_possible_task
from pipeline.route.result import Route
from pipeline.route.straight_ends import require_straight_ends

Vary = Callable[[Config, dict[str, object]], Config]
STRAIGHT = {
    "task.goal": {"x_m": 1.2, "y_m": 0.5, "z_m": 0.9, "mode": "LLL"},
    "refine.approach_m": 0.15,
    "refine.start_direction": [0.3, 1.0, 0.5],
    "refine.goal_direction": [0.0, 0.0, -1.0],
}


@pytest.fixture(scope="module")
def straight_config(quick_config: Config, vary: Vary) -> Config:
    """Ask for straight ends of a short task, longer than a step of the grid."""
    return vary(quick_config, STRAIGHT | {"route.objective": "integral"})


@pytest.fixture(scope="module")
def straight_route(straight_config: Config, machine: Machine) -> Route:
    """Plan it."""
    return plan_route(straight_config, machine, build_regions(straight_config, machine))


def test_a_route_with_straight_ends_leads_from_start_to_goal(straight_config: Config, straight_route: Route) -> None:
    """Along the directions at both ends, two moves each, untilted, in the modes of the ends."""
    position, ends = straight_route.pose[:, :3], straight_config.task
    np.testing.assert_allclose(position[0], [ends.start.x_m, ends.start.y_m, ends.start.z_m], atol=1e-12)
    np.testing.assert_allclose(position[-1], [ends.goal.x_m, ends.goal.y_m, ends.goal.z_m], atol=1e-12)
    for moves, direction in (
        (np.diff(position[:3], axis=0), [0.3, 1.0, 0.5]),
        (np.diff(position[-3:], axis=0), [0, 0, -1]),
    ):
        unit = np.array(direction) / np.linalg.norm(direction)
        np.testing.assert_allclose(moves, np.tile(0.075 * unit, (2, 1)), atol=1e-12)
    assert len({len(straight_route.pose), len(straight_route.kappa), len(straight_route.visits)}) == 1


def test_costs_of_straight_ends_are_those_of_their_moves(straight_config: Config, straight_route: Route) -> None:
    """The objective is the trapezoidal integral along the whole route; the bound moves with it."""
    steps = step_sizes(straight_config.route)
    expected = np.trapezoid(straight_route.kappa, arc_length(straight_route.pose, steps))
    assert straight_route.objective == pytest.approx(expected, rel=1e-9)
    assert straight_route.search.gap < 1e-6
    assert straight_route.search.bound <= straight_route.objective * (1.0 + 1e-9)


def test_check_speaks_of_the_approach_pose(quick_config: Config, machine: Machine, vary: Vary) -> None:
    """Out of reach, or with a cart off its rail: of which end, where it is, and why not."""
    for direction, words in (([-1.0, 0.0, 0.0], "its x_m is"), ([0.0, 1.0, 1.0], "it is out of reach")):
        config = vary(quick_config, {"refine.approach_m": 0.5, "refine.start_direction": direction})
        with pytest.raises(ConfigError, match=r"the approach pose of task.start is x ") as caught:
            require_possible_task(config, machine)
        assert {issue.path for issue in caught.value.issues} == {"refine.approach_m"}
        assert any(words in issue.message for issue in caught.value.issues)


def test_a_straight_move_that_breaks_a_limit_is_refused(straight_config: Config, machine: Machine, vary: Vary) -> None:
    """A box to avoid that both ends of the move are beside: the error says which move, and what it meets."""
    require_straight_ends(straight_config, machine)
    box = {"x_m": [1.19, 1.21], "y_m": [0.49, 0.51], "z_m": [0.93, 0.94]}
    with pytest.raises(ConfigError, match=r"straight move from the approach pose of task.goal to it fails"):
        require_straight_ends(vary(straight_config, {"task.avoid": [box]}), machine)
