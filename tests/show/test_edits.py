"""Changes of a configuration: valid as a file is, and refused as one is."""

import pytest

from pipeline.config import Config, PoseConfig
from pipeline.errors import ConfigError, UsageError
from pipeline.machine import Machine
from pipeline.show.edits import (
    box_around,
    machine_value,
    task_pose,
    task_refusals,
    with_box,
    with_end,
    with_machine,
    with_visit,
    without,
)

POSE = PoseConfig(x_m=1.1, y_m=0.35, z_m=0.85, rx_deg=5.0, mode="LLL")


def test_the_task_is_changed_entry_by_entry(quick_config: Config) -> None:
    """Ends are set, visits and boxes appended in order, and each is found and removed by its name."""
    config = with_end(with_end(quick_config, "start", POSE), "goal", POSE.model_copy(update={"mode": "RRR"}))
    assert task_pose(config, "start") == POSE
    assert task_pose(config, "goal").mode == "RRR"
    box = box_around(POSE, (0.2, 0.1, 0.1), any_x=True)
    config = with_box(with_visit(with_visit(config, POSE), POSE.model_copy(update={"x_m": 1.2})), box)
    assert [visit.pose.x_m for visit in config.task.visit] == [1.1, 1.2]
    assert task_pose(config, "visit[1]").x_m == 1.2
    assert config.task.avoid[0].x_m is None
    assert config.task.avoid[0].y_m == pytest.approx((0.3, 0.4))
    assert [visit.pose.x_m for visit in without(config, "visit[0]").task.visit] == [1.2]
    assert without(config, "avoid[0]").task.avoid == ()
    assert box_around(POSE, (0.2, 0.1, 0.1), any_x=False)["x_m"] == pytest.approx((1.0, 1.2))


def test_what_cannot_be_done_is_said(quick_config: Config) -> None:
    """Ends cannot be removed, boxes have no pose, and values out of bounds name their key."""
    with pytest.raises(UsageError, match="the goal can be moved, not removed"):
        without(quick_config, "goal")
    with pytest.raises(UsageError, match=r"avoid\[0\] is a box"):
        task_pose(with_box(quick_config, box_around(POSE, (0.1, 0.1, 0.1), any_x=False)), "avoid[0]")
    with pytest.raises(ConfigError, match=r"task\.start\.rx_deg"):
        with_end(quick_config, "start", POSE.model_copy(update={"rx_deg": 40.0}))
    with pytest.raises(ConfigError, match=r"machine\.rails\[1\]\.travel_m"):
        with_machine(quick_config, {"rails.1.travel_m": [2.0, 1.0]})


def test_the_machine_is_changed_by_key(quick_config: Config) -> None:
    """A value is what was set, and nothing else changes."""
    config = with_machine(quick_config, {"rails.0.travel_m": [0.0, 2.4]})
    assert machine_value(config, "rails.0.travel_m") == (0.0, 2.4)
    assert with_machine(config, {"rails.0.travel_m": [0.0, 2.1]}) == quick_config


def test_the_task_is_checked(quick_config: Config, machine: Machine) -> None:
    """A task that `check` accepts has no refusals; one that cannot be has them with their keys."""
    assert task_refusals(quick_config, machine) == []
    same = with_end(quick_config, "goal", quick_config.task.start)
    assert any(text.startswith("task.goal: is the start itself") for text in task_refusals(same, machine))
