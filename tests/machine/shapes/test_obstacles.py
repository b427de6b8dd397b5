"""Pairs of what moves and what is fixed in space."""

import pytest

from pipeline.config import Config
from pipeline.machine import build_machine
from pipeline.machine.geometry import LINKS
from pipeline.machine.shapes.obstacles import build_obstacles

POST = {"capsule": {"from_m": [2.25, 0.0, 0.0], "to_m": [2.25, 0.0, 1.5], "radius_m": 0.03}}
WORKPIECE = {"name": "workpiece", "box": {"centre_m": [1.0, -0.1, 0.7], "size_m": [0.4, 0.3, 0.3]}}


@pytest.fixture(scope="module")
def config(bodies_config: Config, vary) -> Config:
    """Take the posts away from the machine with bodies."""
    bodies = bodies_config.model_dump()["machine"]["bodies"]
    return vary(bodies_config, {"machine.bodies": [body for body in bodies if not body["name"].startswith("post")]})


def test_without_anything_fixed_there_are_none(config: Config) -> None:
    """Beams are no obstacles: x plays no role in distances from them."""
    assert build_obstacles(config.machine, ()) is None
    assert build_machine(config.machine).obstacles is None


def test_of_a_platform_without_bodies_the_tcp_is_kept_apart(quick_config: Config, vary) -> None:
    """And the axes of the links."""
    config = vary(quick_config, {"task.obstacles": [WORKPIECE]})
    found = build_obstacles(config.machine, config.task.obstacles)
    assert found is not None
    assert found.names == (*(f"link {name} and workpiece" for name in LINKS), "TCP and workpiece")


def test_bodies_of_the_frame_are_the_machines_obstacles(config: Config, vary) -> None:
    """They are no part of the pairs that do not depend on x; those of the task come with them."""
    post = {"name": "post", "attached_to": "frame", **POST}
    bodies = [*config.model_dump()["machine"]["bodies"], post]
    config = vary(config, {"machine.bodies": bodies, "task.obstacles": [WORKPIECE]})
    machine = build_machine(config.machine)
    assert machine.bodies is not None
    assert machine.obstacles is not None
    assert not any("post" in name for name in machine.bodies.names)
    assert {name.split(" and ")[1] for name in machine.obstacles.names} == {"post"}
    both = build_obstacles(config.machine, config.task.obstacles)
    assert both is not None
    assert len(both.pairs) == 2 * len(machine.obstacles.pairs)
    assert "TCP and post" not in both.names
    assert {"nose and workpiece", "saddle1 and post", "tube 2b and workpiece"} <= set(both.names)


def test_ignored_pairs_are_left_out(config: Config, vary) -> None:
    """A tool may touch its workpiece."""
    ignored = {"task.obstacles": [WORKPIECE], "machine.clearance.ignore": [["nose", "workpiece"]]}
    config = vary(config, ignored)
    found = build_obstacles(config.machine, config.task.obstacles)
    assert found is not None
    assert "nose and workpiece" not in found.names
    assert [one.name for one in found.neighbours] == ["nose and workpiece"]
