"""Start and goal of the task: where the machine is there, and every reason why it cannot be."""

from typing import Any

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.file import parse_config
from pipeline.errors import ConfigError
from pipeline.limits.actuator_margins import controlled_pose
from pipeline.machine import Machine, build_machine, inverse_kinematics
from pipeline.machine.clearance import link_rail_distances
from pipeline.route.regions.endpoints import task_endpoints


def changed(config: Config, changes: dict[str, Any]) -> Config:
    """Copy a configuration with some keys, given by their paths, changed."""
    data = config.model_dump(mode="json")
    for path, value in changes.items():
        *sections, key = path.split(".")
        part = data
        for section in sections:
            part = part[section]
        part[key] = value
    return parse_config(data)


def refusal(config: Config, changes: dict[str, Any]) -> list[str]:
    """Messages of a configuration whose start or goal the machine cannot be at."""
    forces = ("carts.force_n", "telescopes.force_n", "link_force_n")
    config = changed(config, {f"machine.limits.{key}": None for key in forces} | changes)
    with pytest.raises(ConfigError) as caught:
        task_endpoints(config, build_machine(config.machine))
    assert caught.value.exit_code == 2
    return [str(issue) for issue in caught.value.issues]


def test_reference_task_has_its_ends(agder_config: Config, machine: Machine):
    """Start and goal of the reference task are LLL and RRR at the poses given, on the same side of det H."""
    start, goal = task_endpoints(agder_config, machine)
    assert (start.mode, goal.mode) == (0, 7)
    np.testing.assert_array_equal(start.pose[[0, 1, 2, 3, 5]], [1.02, 0.3, 0.9, 0.0, 0.0])
    np.testing.assert_allclose(start.q_m[3:], [1.09, 1.25], atol=1e-12)
    assert start.kappa == pytest.approx(23.1446, abs=1e-3)
    assert start.det_sign == goal.det_sign == 1.0
    assert start.samples.link_distance_m[0] > machine.link_link_m
    solution = inverse_kinematics(machine, controlled_pose(agder_config.task.goal)[None], np.array([7]))
    np.testing.assert_array_equal(goal.q_m, solution.q_m[0])


def test_tilts_are_read_in_degrees(agder_config: Config):
    """Controlled poses have rx and rz in radians."""
    config = changed(agder_config, {"task.start.rx_deg": 30.0, "task.start.rz_deg": -10.0})
    np.testing.assert_allclose(controlled_pose(config.task.start), [1.02, 0.3, 0.9, np.pi / 6, -np.pi / 18])


@pytest.mark.parametrize(
    ("changes", "arms"),
    [
        ({"task.start.z_m": 1.6}, "arm 3"),
        ({"task.start.z_m": 0.1, "task.start.y_m": 1.0}, "arm 1 and arm 2"),
        ({"task.start.z_m": 0.42}, "arm 2"),
    ],
)
def test_an_unreachable_start_names_the_arms(agder_config: Config, changes: dict[str, Any], arms: str):
    """Out of reach is told with the arms that are too short."""
    (message,) = refusal(agder_config, changes)
    assert message.startswith(f"task.start: is out of reach for {arms}: ")


def test_both_ends_are_told_at_once(agder_config: Config):
    """A start and a goal that are both impossible give a message each."""
    messages = refusal(agder_config, {"task.start.z_m": 1.6, "task.goal.z_m": 1.7})
    assert [message.split(":")[0] for message in messages] == ["task.start", "task.goal"]


def test_a_triangle_that_cannot_close_is_named(agder_config: Config):
    """All arms may reach and yet the triangle not close: that is another reason."""
    changes = {"machine.links.l3c.length_m": 1.36, "task.start.y_m": 0.6, "task.start.rx_deg": 11.0}
    (message, *_) = refusal(agder_config, changes)
    assert message.startswith("task.start: is out of reach: the triangle of links 3a and 3c")


def test_carts_off_their_rails_are_named(agder_config: Config):
    """Each cart beyond its travel is told with its position and what is allowed, and then the x that would do."""
    messages = refusal(agder_config, {"task.start.x_m": 0.1})
    assert len(messages) == 4
    assert messages[3].startswith("task.start.x_m: is 0.1; all carts are on their rails for 0.9999 to ")
    assert messages[0] == "task.start: needs c1 at -0.8998 m; allowed are 0 to 2.1 m"


def test_telescopes_beyond_their_strokes_are_named(agder_config: Config):
    """A telescope that would be too short or too long is told like a cart."""
    messages = refusal(
        agder_config, {"machine.links.l2b.stroke_m": [1.1, 1.2], "machine.links.l3b.stroke_m": [1.0, 1.2]}
    )
    assert messages[0] == "task.start: needs l2b at 1.0900 m; allowed are 1.1 to 1.2 m"
    assert messages[3] == "task.goal: needs l3b at 1.2500 m; allowed are 1 to 1.2 m"


def test_a_goal_in_a_wrong_mode_is_told_with_the_right_ones(agder_config: Config):
    """A goal with the opposite sign of det H cannot be reached; modes with the start's sign are listed."""
    (message,) = refusal(agder_config, {"task.goal.mode": "RRL", "route.kappa_max": 1000.0})
    assert message.startswith("task.goal.mode: is RRL, where det H has the opposite sign of the start's")
    assert message.endswith("LLL, LLR, LRL, LRR, RLL, RLR, RRR")


def test_a_goal_no_mode_suits_says_so(agder_config: Config):
    """Where no working mode has the start's sign, none is listed."""
    changes = {"task.start.mode": "RRL", "task.goal.y_m": 0.0, "task.goal.z_m": 0.7, "route.kappa_max": 1e4}
    (message,) = refusal(agder_config, changes)
    assert message.startswith("task.goal.mode: is RRR")
    assert message.endswith(": none")


@pytest.mark.parametrize("end", ["start", "goal"])
def test_a_pose_too_near_a_singularity_is_refused(agder_config: Config, end: str):
    """Kappa above the cap is told with both values."""
    (message,) = refusal(agder_config, {f"task.{end}.mode": "RRL"})
    assert message == f"task.{end}: has kappa 796.1, above route.kappa_max (100)"


def test_links_too_close_are_told(agder_config: Config):
    """A clearance larger than the machine has at an end is refused with the distance."""
    messages = refusal(agder_config, {"machine.clearance.link_link_m": 0.0953})
    assert messages == ["task.goal: has links 0.0950 m apart; machine.clearance.link_link_m asks for 0.0953 m"]


def test_links_too_close_to_a_rail_are_told(agder_config: Config):
    """Rails count only where a distance to them is asked for."""
    messages = refusal(agder_config, {"machine.clearance.link_rail_m": 0.61})
    assert messages[0] == "task.start: has a link 0.6041 m from a rail; machine.clearance.link_rail_m asks for 0.61 m"
    config = changed(agder_config, {"machine.clearance.link_rail_m": 0.6})
    start, _ = task_endpoints(config, build_machine(config.machine))
    distances = link_rail_distances(start.samples.machine, start.samples.pose, start.samples.carts_m)
    assert distances.min() == pytest.approx(0.6041, abs=1e-4)


def test_drives_that_cannot_hold_the_machine_are_told(agder_config: Config):
    """Each with the force it needs at rest, and what it may take."""
    (message,) = refusal(agder_config, {"machine.limits.carts.force_n": 120.0})
    assert message == (
        "task.start: needs 143 N from c1 to hold the machine; at most 120 N is allowed (its force limit of 120 N)"
    )
    assert len(refusal(agder_config, {"machine.limits.carts.force_n": 100.0})) == 3


def test_a_goal_that_is_the_start_is_refused(agder_config: Config):
    """There is nothing to plan; another working mode at the same pose is a task."""
    found = refusal(agder_config, {"task.goal.mode": "LLL"})
    assert found == ["task.goal: is the start itself, in the same working mode: there is nothing to plan"]


@pytest.mark.parametrize("end", ["start", "goal"])
def test_the_start_or_goal_is_no_visit(agder_config: Config, end: str):
    """Every route is there; the same pose in another working mode may be visited."""
    data = agder_config.model_dump(mode="json")
    box = {"y_m": [0.5, 0.7]}
    found = refusal(agder_config, {"task.visit": [{"box": box}, {"pose": data["task"][end]}]})
    assert found == [f"task.visit[1].pose: is the {end} itself, in the same working mode: leave the visit out"]
    config = changed(agder_config, {"task.visit": [{"pose": {**data["task"]["goal"], "mode": "RLL"}}]})
    assert len(task_endpoints(config, build_machine(config.machine))) == 2


def test_an_end_beside_a_box_keeps_the_margin_of_the_route(agder_config: Config):
    """Regions keep route.avoid_margin grid steps from boxes, so that no move would join a start that does not."""
    step = agder_config.route.grid.y_m.step
    box = {"y_m": [0.3 + 0.1 * step, 0.6]}
    found = refusal(agder_config, {"task.avoid": [{"y_m": [0.7, 0.8]}, box], "task.goal.y_m": 0.2})
    assert found == [
        "task.start: is within route.avoid_margin of task.avoid[1] (0.25 grid steps), where moves do not go"
    ]
    config = changed(agder_config, {"task.avoid": [box], "route.avoid_margin": 0.1})
    assert len(task_endpoints(config, build_machine(config.machine))) == 2
