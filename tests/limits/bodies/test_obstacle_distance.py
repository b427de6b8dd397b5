"""The limit of distances from obstacles: which uses have it, and what could give."""

from pipeline.config import Config
from pipeline.limits import move_limits, path_limits, pose_limits, relaxations, task_pose_limits
from pipeline.limits.bodies import obstacle_distance
from pipeline.machine import Machine

WORKPIECE = {"name": "workpiece", "box": {"centre_m": [1.0, -0.5, 0.2], "size_m": [0.4, 0.3, 0.3]}}
BALL = {"name": "ball", "hull": {"points_m": [[0.0, -1.0, 0.0]], "radius_m": 0.1}}


def names(limits) -> list[str]:
    """Name limits."""
    return [limit.wording.name for limit in limits]


def test_paths_and_poses_with_an_x_of_their_own_have_it(quick_config: Config, machine: Machine, vary) -> None:
    """Poses of the grid have none: their windows of x are cut."""
    config = vary(quick_config, {"task.obstacles": [WORKPIECE]})
    assert "obstacle distance" not in names(pose_limits(machine, 100.0))
    assert "obstacle distance" not in names(move_limits(config, machine, given_x=False))
    for limits in (move_limits(config, machine), path_limits(config, machine), task_pose_limits(config, machine)):
        assert names(limits).count("obstacle distance") == 1
    assert "obstacle distance" not in names(path_limits(quick_config, machine))


def test_obstacles_of_the_task_could_give(quick_config: Config, machine: Machine, vary) -> None:
    """All of them, and each alone."""
    config = vary(quick_config, {"task.obstacles": [WORKPIECE, BALL]})
    found = {one.key: one for one in relaxations(config, machine)}
    assert found["task.obstacles[1]"].part_of == "task.obstacles"
    assert [one.name for one in found["task.obstacles[1]"].change(1.0).task.obstacles] == ["workpiece"]
    assert found["task.obstacles"].change(1.0).task.obstacles == ()


def test_premises_are_the_obstacles(quick_config: Config, vary) -> None:
    """Certificates of tasks without any stay as they are."""
    config = vary(quick_config, {"task.obstacles": [WORKPIECE]})
    assert obstacle_distance.CERTIFICATE.premises(quick_config) == {}
    assert obstacle_distance.CERTIFICATE.premises(config)["obstacles"][0]["name"] == "workpiece"
