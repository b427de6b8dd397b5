"""Bodies in the configuration: what is refused, with its key, and what changes nothing."""

import copy
from typing import Any

import pytest
import yaml

from pipeline.config import Config
from pipeline.config.file import config_sha256, dump_config, parse_config
from pipeline.errors import ConfigError
from tests.conftest import CONFIGS

SPHERE = {"from_m": [0.0, 0.0, 0.0], "to_m": [0.0, 0.0, 0.0], "radius_m": 0.02}
BEAM = {"points_m": [[0.0, 0.0]], "radius_m": 0.02}
DATA = yaml.safe_load((CONFIGS / "agder-bodies.yaml").read_text())
PLAIN = yaml.safe_load((CONFIGS / "agder.yaml").read_text())


def messages(change: dict[str, Any], data: dict[str, Any] = DATA) -> list[str]:
    """Say what is wrong with a changed section of the machine."""
    changed = copy.deepcopy(data)
    for key, value in change.items():
        section, _, inner = key.partition(".")
        if inner:
            changed["machine"][section][inner] = value
        else:
            changed["machine"][section] = value
    with pytest.raises(ConfigError) as error:
        parse_config(changed)
    return [f"{issue.path}: {issue.message}".removeprefix("machine.") for issue in error.value.issues]


def body(**keys: Any) -> list[dict[str, Any]]:
    """Make a list of one body."""
    return [{"name": "it", "attached_to": "platform", **keys}]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"bodies": body()}, "bodies[0]: has no shape: give exactly one of capsule, box, hull, mesh and beam"),
        (
            {"bodies": body(capsule=SPHERE, hull={"points_m": [[0.0, 0.0, 0.0]]})},
            "bodies[0]: has capsule and hull: give exactly one of capsule, box, hull, mesh and beam",
        ),
        (
            {"bodies": body(beam=BEAM)},
            "bodies[0].beam: is endless along X and moves with platform; attach it to a rail or the frame",
        ),
        (
            {"bodies": body(capsule=SPHERE) * 2},
            "bodies: has it more than once, or as the name of a link; every body needs its own name",
        ),
        (
            {"bodies": [{"name": "l2a", "attached_to": "cart1", "capsule": SPHERE}]},
            "bodies: has l2a more than once, or as the name of a link; every body needs its own name",
        ),
        (
            {"bodies": body(box={"size_m": [0.1, 0.1, 0.02], "rounding_m": 0.011})},
            "bodies[0].box.rounding_m: is 0.011; allowed is at most half the least side of size_m",
        ),
        (
            {"bodies": body(attached_to="cart4", capsule=SPHERE)},
            'bodies[0].attached_to: is "cart4"; allowed is platform or cart1 or cart2 or cart3 or rail1 or rail2 or '
            "rail3 or frame or l1_cart or l1_platform or l2a_cart or l2a_platform or l2b_cart or l2b_platform or "
            "l3a_cart or l3a_platform or l3b_cart or l3b_platform or l3c_cart or l3c_platform",
        ),
        (
            {"bodies": body(attached_to="cart1", capsule=SPHERE, tool=True)},
            "bodies[0].tool: is on, of a body of cart1; tools are on the platform",
        ),
        (
            {"bodies": body(attached_to="rail2", capsule=SPHERE)},
            "bodies[0].attached_to: is rail2, of which a body is a beam; attach others to the frame",
        ),
        (
            {"bodies": body(attached_to="l2b_cart", box={"size_m": [0.1, 0.1, 0.1]})},
            "bodies[0].attached_to: is l2b_cart, and joints leave open how far a link turns about its axis: only a "
            "capsule on that axis is the same for all",
        ),
        (
            {"bodies": body(attached_to="l2b_cart", capsule={**SPHERE, "to_m": [0.0, 0.01, 0.2]})},
            "bodies[0].capsule.to_m: is off the axis of the link, along z; x and y have to be 0",
        ),
        (
            {"bodies": body(attached_to="l2b_platform", capsule={**SPHERE, "to_m": [0.0, 0.0, 0.1]})},
            "bodies[0].capsule.to_m: is beyond the joint; z of a body of l2b_platform is at most 0",
        ),
        (
            {"bodies": body(attached_to="l2b_platform", capsule={**SPHERE, "to_m": [0.0, 0.0, -0.96]})},
            "bodies[0].capsule: reaches 0.96 m along link l2b, which is 0.95 m long at least",
        ),
        (
            {"clearance.ignore": [["nose", "l4"]]},
            "clearance.ignore: names l4; allowed are the names of bodies and l1, l2a, l2b, l3a, l3b, l3c",
        ),
        (
            {"clearance.link_link_m": 0.03},
            "clearance.link_link_m: is 0.03, between axes, where machine.link_bodies gives the links surfaces: leave "
            "it out; machine.clearance.bodies_m is kept between these",
        ),
        (
            {"clearance.joint_trim_m": {"platform": 0.5, "cart": 0.46}},
            "clearance.joint_trim_m: leaves nothing of link l2b, 0.95 m long at least",
        ),
        (
            {"link_bodies.l2b": {"rod_radius_m": 0.02, "tube_radius_m": 0.01, "tube_length_m": 0.5}},
            "link_bodies.l2b.tube_radius_m: is 0.01; allowed is at least rod_radius_m",
        ),
        (
            {"link_bodies.l2b": {"rod_radius_m": 0.01, "tube_radius_m": 0.01, "tube_length_m": 0.96}},
            "link_bodies.l2b.tube_length_m: is 0.96; allowed is more than clearance.joint_trim_m.cart (0.12), at most "
            "the least stroke (0.95)",
        ),
    ],
)
def test_what_is_wrong_is_said_with_its_key(change: dict[str, Any], expected: str) -> None:
    """One message per fault, with the name of the body that it is in."""
    name = ' (of "it")' if expected.startswith("bodies[") else ""
    assert messages(change) == [expected + name]


def test_a_distance_of_links_is_needed_of_axes_or_bodies() -> None:
    """Links without either would pass through each other."""
    expected = "clearance.link_link_m: is missing; allowed is a number from 0 to 1, or machine.link_bodies"
    assert messages({"clearance": {}}, PLAIN) == [expected]


@pytest.mark.parametrize("key", ["bodies_m", "joint_trim_m", "ignore"])
def test_clearances_of_bodies_without_bodies_are_refused(key: str) -> None:
    """No key is read and ignored."""
    value = {"bodies_m": 0.01, "joint_trim_m": {"cart": 0.1}, "ignore": [["l1", "l2a"]]}[key]
    found = messages({f"clearance.{key}": value}, PLAIN)
    assert found == [f"clearance.{key}: is of bodies, and there are none: leave it out, or give machine.bodies"]


def test_configurations_without_bodies_keep_their_hash(agder_config: Config) -> None:
    """Nothing of bodies is written, or counted, where there are none: results of before stay up to date."""
    machine = yaml.safe_load(dump_config(agder_config))["machine"]
    assert not {"bodies", "link_bodies"} & set(machine)
    assert not {"bodies_m", "joint_trim_m", "ignore"} & set(machine["clearance"])
    assert not {"bodies", "link_bodies"} & set(agder_config.model_dump(mode="json")["machine"])


def test_it_is_written_as_it_was_given(bodies_config: Config) -> None:
    """The resolved configuration is read back, and means the same."""
    written = yaml.safe_load(dump_config(bodies_config))
    assert parse_config(written) == bodies_config
    assert list(written["machine"]["bodies"][0]) == ["name", "attached_to", "capsule"]


def test_obstacles_have_names_of_their_own(bodies_config: Config, vary: Any) -> None:
    """A body and an obstacle of one name could not be told apart in messages."""
    obstacle = {"name": "nose", "hull": {"points_m": [[1.0, 0.0, 0.0]]}}
    with pytest.raises(ConfigError) as error:
        vary(bodies_config, {"task.obstacles": [obstacle]})
    assert [str(issue.path) for issue in error.value.issues] == ["task.obstacles"]
    assert "has nose more than once" in error.value.issues[0].message


def test_clearances_count_where_there_are_obstacles_alone(agder_config: Config, vary: Any) -> None:
    """Links and the TCP keep that distance from them."""
    obstacle = {"name": "wall", "hull": {"points_m": [[1.0, 3.0, 0.0]]}}
    config = vary(agder_config, {"task.obstacles": [obstacle], "machine.clearance.bodies_m": 0.02})
    assert config.machine.clearance.bodies_m == 0.02
    assert config_sha256(config) != config_sha256(agder_config)


def test_the_tool_of_a_task_replaces_that_of_the_machine(bodies_config: Config, vary: Any) -> None:
    """The resolved configuration has it among the machine's bodies, and is read back as it is."""
    bodies = copy.deepcopy(bodies_config.model_dump(mode="json")["machine"]["bodies"])
    assert bodies[7]["name"] == "nose"
    bodies[7]["tool"] = True
    tool = [{"name": "gripper", "capsule": SPHERE}, {"name": "finger", "capsule": {**SPHERE, "radius_m": 0.01}}]
    config = vary(bodies_config, {"machine.bodies": bodies, "task.tool": tool})
    assert [body.name for body in config.machine.bodies if body.tool] == ["gripper", "finger"]
    assert "nose" not in {body.name for body in config.machine.bodies}
    assert {body.attached_to for body in config.machine.bodies if body.tool} == {"platform"}
    assert parse_config(yaml.safe_load(dump_config(config))) == config
    other = vary(config, {"task.tool": tool[:1]})
    assert [body.name for body in other.machine.bodies if body.tool] == ["gripper"]


def test_what_is_wrong_with_a_tool_is_said_of_the_task(bodies_config: Config, vary: Any) -> None:
    """Not of the machine, where it is put."""
    with pytest.raises(ConfigError) as error:
        vary(bodies_config, {"task.tool": [{"name": "it"}]})
    found = [f"{issue.path}: {issue.message}" for issue in error.value.issues]
    assert found == ['task.tool[0]: has no shape: give exactly one of capsule, box, hull and mesh (of "it")']


def test_a_fault_of_a_body_has_its_name(bodies_config: Config):
    """Its place in the list alone is hard to find."""
    data = bodies_config.model_dump(mode="json", exclude_none=True)
    data["machine"]["bodies"][8]["box"]["rounding_m"] = 0.9
    with pytest.raises(ConfigError, match=r'bodies\[8\]\.box\.rounding_m: .* \(of "saddle1"\)'):
        parse_config(data)
