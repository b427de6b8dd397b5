"""The rules of the configuration: what it fills in, and what it refuses, key by key."""

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline.config import Config, FollowConfig, RefineConfig, RetimeConfig
from pipeline.config.file import parse_config
from pipeline.errors import ConfigError

AGDER = yaml.safe_load((Path(__file__).parents[2] / "configs" / "agder.yaml").read_text())

METRES = "a number from -20 to 20"
POSITIVE = "a number above 0, at most 20"
TILTED = {"x_m": 1.0, "y_m": 0.6, "z_m": 0.7, "rx_deg": 5, "mode": "LLL"}


def with_value(path: str, value: object, *more: object) -> dict[str, Any]:
    """Set keys of the reference configuration, path and value by turns; numbers in a path are places in a list."""
    data: dict[str, Any] = copy.deepcopy(AGDER)
    paths, values = (path, *more[::2]), (value, *more[1::2])
    for where, what in zip(paths, values, strict=True):
        *sections, key = str(where).split(".")
        part: Any = data
        for section in sections:
            part = part[int(section)] if section.isdigit() else part.setdefault(section, {})
        part[key] = what
    return data


def without(path: str) -> dict[str, Any]:
    """Leave out one key of the reference configuration."""
    data: dict[str, Any] = copy.deepcopy(AGDER)
    *sections, key = path.split(".")
    part: Any = data
    for section in sections:
        part = part[int(section)] if section.isdigit() else part[section]
    del part[key]
    return data


def messages(data: dict[str, Any]) -> list[str]:
    """What is wrong with a configuration."""
    with pytest.raises(ConfigError) as caught:
        parse_config(data)
    assert caught.value.exit_code == 2
    return [str(issue) for issue in caught.value.issues]


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        # wrong units
        ("task.start.x_m", 2100, f"is 2100; allowed is {METRES} (the unit is metres: is 2100 in millimetres?)"),
        ("task.start.y_m", -300.0, f"is -300.0; allowed is {METRES} (the unit is metres: is -300.0 in millimetres?)"),
        (
            "machine.rails.0.travel_m",
            [0, 2100],
            "[1]: is 2100; allowed is a number from -20 to 20 (the unit is metres: is 2100 in millimetres?)",
        ),
        ("machine.links.l1.length_m", 1090, f"is 1090; allowed is {POSITIVE} (the unit is metres: is 1090 in milli"),
        (
            "machine.clearance.link_link_m",
            30,
            "is 30; allowed is a number from 0 to 1 or null (the unit is metres: is 30",
        ),
        (
            "machine.limits.carts.velocity_mps",
            500,
            "(the unit is metres per second: is 500 in millimetres per second?)",
        ),
        (
            "machine.limits.telescopes.acceleration_mps2",
            5000,
            "(the unit is metres per second squared: is 5000 in milli",
        ),
        ("route.grid.y_m.step", 60, "(the unit is metres: is 60 in millimetres?)"),
        (
            "retime.period_s",
            10,
            "allowed is a number from 0.000125 to 0.1 (the unit is seconds: is 10 in milliseconds?)",
        ),
        ("task.start.x_m", 1e9, f"is 1000000000.0; allowed is {METRES}"),
        # negative, zero and out of range
        ("machine.limits.carts.velocity_mps", -0.5, "is -0.5; allowed is a number from 0 to 20"),
        ("machine.limits.carts.acceleration_mps2", 0, "is 0; allowed is a number above 0, at most 500"),
        ("machine.links.l2a.length_m", -1.09, f"is -1.09; allowed is {POSITIVE}"),
        ("machine.links.l3c.length_m", 0.0, f"is 0.0; allowed is {POSITIVE} or null"),
        ("machine.links.l2b.stroke_m", [-0.95, 1.25], f"[0]: is -0.95; allowed is {POSITIVE}"),
        ("machine.clearance.link_rail_m", -0.01, "is -0.01; allowed is a number from 0 to 1 or null"),
        ("task.tilt_max_deg", 90, "is 90; allowed is a number from 0 to 85"),
        ("task.goal.rz_deg", -100, "is -100; allowed is a number from -85 to 85"),
        ("route.step_budget", 1, "is 1; allowed is a whole number from 2 to 500"),
        ("route.kappa_max", 1.0, "is 1.0; allowed is a number above 1"),
        ("route.x_step_m", 0, f"is 0; allowed is {POSITIVE}"),
        ("route.time_limit_s", 0, "is 0; allowed is a number above 0"),
        ("route.follow.max_samples", 4, "is 4; allowed is a whole number from 8 to 16384"),
        ("refine.coefficients", 5, "is 5; allowed is a whole number from 8 to 400"),
        ("retime.grid_points", 10, "is 10; allowed is a whole number from 50 to 20000"),
        # not a number, not a list, not a section
        ("task.start.x_m", "far", f'is "far"; allowed is {METRES}'),
        ("task.start.x_m", None, f"is null; allowed is {METRES}"),
        ("task.start.x_m", float("nan"), f"is NaN; allowed is {METRES}"),
        ("task.start.x_m", float("inf"), f"is Infinity; allowed is {METRES}"),
        ("task.start.x_m", True, f"is true; allowed is {METRES}"),
        ("machine.rails.0.travel_m", [False, 2.1], "is false; allowed is a number from -20 to 20"),
        ("machine.rails.0.travel_m", 2.1, "is 2.1; allowed is a list of 2 numbers from -20 to 20"),
        ("machine.rails.0.travel_m", [0, 1, 2], "is [0, 1, 2]; allowed is a list of 2 numbers from -20 to 20"),
        ("machine.links.l1.platform_point_m", [0, 0], f"[2]: is missing; allowed is {METRES}"),
        ("machine.rails", [], "[0]: is missing; allowed is a section with the keys y_m, z_m, travel_m"),
        ("machine.rails", [1] * 4, "is [1, 1, 1, 1]; allowed is a list of 3 sections"),
        (
            "machine.links.l1",
            1.09,
            "is 1.09; allowed is a section with the keys platform_point_m, cart_offset_m, length_m",
        ),
        ("machine.links", ["l1"] * 30, "..; allowed is a section with the keys l1, l2a, l2b, l3a, l3b, l3c"),
        ("route.step_budget", 2.5, "is 2.5; allowed is a whole number from 2 to 500"),
        ("route.step_budget", "many", 'is "many"; allowed is a whole number from 2 to 500'),
        # choices and patterns
        ("machine.triangle_branch", "up", 'is "up"; allowed is negative or positive'),
        ("task.locked_axes", ["ry"], '[0]: is "ry"; allowed is rx or rz'),
        ("task.locked_axes", "rx", 'is "rx"; allowed is a list of rx or rz'),
        ("task.start.mode", "LLX", 'is "LLX"; allowed is three letters L or R, one per arm, such as LLL'),
        ("task.start.mode", "LLLL", 'is "LLLL"; allowed is three letters L or R'),
        ("task.start.mode", "lll", 'is "lll"; allowed is three letters L or R'),
        ("task.start.mode", 7, "is 7; allowed is three letters L or R"),
        ("name", "a/b", "is \"a/b\"; allowed is letters, digits, '_', '-' and '.', the first a letter, a digit or '_'"),
        ("name", "..", 'is ".."; allowed is letters'),
        ("name", 12, "is 12; allowed is letters"),
    ],
)
def test_a_bad_value_is_reported_with_its_path_and_what_is_allowed(path: str, value: object, message: str):
    """One message per key: where it is, what was found, what is allowed, and the unit when that is the likely slip."""
    found = messages(with_value(path, value))[0]
    name = ".".join(path.split(".")).replace(".0.", "[0].")
    assert found.startswith(name)
    assert message in found
    assert not any(word in found for word in ("Value error", "Input should", "Config", "tuple", "dictionary", "\n"))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (
            with_value("machine.rails.1.travel_m", [2.1, 0.0]),
            "machine.rails[1].travel_m: is [2.1, 0.0]; allowed is [least, largest] with least below largest",
        ),
        (
            with_value("machine.links.l2b.stroke_m", [1.0, 1.0]),
            "machine.links.l2b.stroke_m: is [1.0, 1.0]; allowed is [least, largest] with least below largest",
        ),
        (
            with_value("task.start.rx_deg", -31),
            "task.start.rx_deg: is -31; allowed is at most 30 either way (task.tilt_max_deg)",
        ),
        (
            with_value("task.locked_axes", ["rz"], "task.goal.rz_deg", 5),
            "task.goal.rz_deg: is 5; allowed is at most 0 either way (task.locked_axes)",
        ),
        (
            with_value("task.locked_axes", ["rx"], "task.visit", [{"box": {"x_m": [0, 1]}}, {"pose": TILTED}]),
            "task.visit[1].pose.rx_deg: is 5; allowed is at most 0 either way (task.locked_axes)",
        ),
        (
            with_value("task.tilt_max_deg", 4, "task.visit", [{"pose": TILTED}]),
            "task.visit[0].pose.rx_deg: is 5; allowed is at most 4 either way (task.tilt_max_deg)",
        ),
        (
            with_value("task.locked_axes", ["rx", "rx"]),
            "task.locked_axes: is [rx, rx]; allowed is each axis once",
        ),
        (
            with_value("task.visit", [{"pose": TILTED, "box": {"x_m": [0, 1]}}]),
            "task.visit[0]: needs exactly one of pose and box",
        ),
        (
            with_value("route.grid.z_m.min", 2.0),
            "route.grid.z_m.max: is 1.5, below min (2): the grid is empty",
        ),
        (
            with_value("refine", {"nodes": 40, "coefficients": 50}),
            "refine.coefficients: is 50; allowed are at most as many as nodes (40)",
        ),
        (
            with_value("machine.links.l3c.length_m", 1.5),
            "machine.links.l3c.length_m: is 1.5, which cannot close the triangle with link 3a (1.25 m) and the "
            "platform side (0.13 m)",
        ),
        (
            with_value("machine.links.l3c.cart_offset_m", [0.0, 0.1, 0.0]),
            "machine.links.l3c.length_m: is missing; it can be left out only when 3a and 3c have one cart_offset_m",
        ),
        (
            with_value("machine.links.l3c.platform_point_m", [0.0, 0.3, 0.0]),
            "machine.links.l3c.platform_point_m: must not lie on the line through 3a's along y: nothing holds ry",
        ),
    ],
)
def test_a_rule_between_keys_names_the_key_to_look_at(data: dict[str, Any], message: str):
    """Rules that involve several keys are reported at one of them, with its full path."""
    assert messages(data) == [message]


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("task.goal", "is missing; allowed is a section with the keys x_m, y_m, z_m, rx_deg, rz_deg, mode"),
        ("task.start.mode", "is missing; allowed is three letters L or R, one per arm, such as LLL"),
        ("machine.rails.0.y_m", "is missing; allowed is a number from -20 to 20"),
        ("machine.links.l2b.stroke_m", "is missing; allowed is a list of 2 numbers above 0, at most 20"),
        (
            "machine",
            "is missing; allowed is a section with the keys rails, links, triangle_branch, characteristic_length_m, "
            "clearance, bodies, link_bodies, limits, dynamics",
        ),
    ],
)
def test_a_missing_key_is_named(path: str, message: str):
    """A missing key is reported with what belongs there."""
    assert messages(without(path)) == [f"{path.replace('.0.', '[0].')}: {message}"]


@pytest.mark.parametrize(
    ("path", "message"),
    [
        (
            "routes",
            "routes: is not a known key (did you mean route?); allowed here are name, machine, task, route, refine",
        ),
        ("machine.rails.1.z", "machine.rails[1].z: is not a known key; allowed here are y_m, z_m, travel_m"),
        (
            "task.start.rx_rad",
            "task.start.rx_rad: is not a known key (did you mean rx_deg?); allowed here are x_m, y_m",
        ),
        ("route.grid.y_m.steps", "route.grid.y_m.steps: is not a known key (did you mean step?); allowed here are min"),
        ("retime.dt", "retime.dt: is not a known key; allowed here are grid_points, period_s"),
    ],
)
def test_an_unknown_key_is_refused_with_a_suggestion(path: str, message: str):
    """Unknown keys are errors; the likeliest known one comes first."""
    (found,) = messages(with_value(path, 1))
    assert found.startswith(message)


@pytest.mark.parametrize(
    ("visit", "message"),
    [
        ({"box": {"x": [0, 1]}}, "task.visit[0].box.x: is not a known key; allowed here are x_m, y_m, z_m"),
        ({"pose": {"z": 1}}, "task.visit[0].pose.z: is not a known key; allowed here are x_m, y_m, z_m"),
        ({"box": 5}, "task.visit[0].box: is 5; allowed is a section with the keys x_m, y_m, z_m, rx_deg, rz_deg or nu"),
    ],
)
def test_optional_sections_are_reported_like_others(visit: dict[str, Any], message: str):
    """An unknown key inside one is reported with the known ones; a value in its place may also be null."""
    assert any(found.startswith(message) for found in messages(with_value("task.visit", [visit])))


def test_a_key_that_is_no_text_is_refused():
    """YAML allows numbers as keys; the configuration does not."""
    data = copy.deepcopy(AGDER)
    data["machine"][5] = 1
    (found,) = messages(data)
    assert found.startswith("machine[5]: is not a known key; allowed here are rails")


def test_all_errors_are_reported_together():
    """Several mistakes give several messages, one per line, under the name of the source."""
    data = with_value("task.start.x_m", 2100)
    data["route"]["kappa_max"] = 0
    data["refine"] = {"node": 3}
    with pytest.raises(ConfigError) as caught:
        parse_config(data, source="my.yaml")
    lines = str(caught.value).splitlines()
    assert lines[0] == "my.yaml cannot be used:"
    assert [line.split(":")[0].strip() for line in lines[1:]] == ["task.start.x_m", "route.kappa_max", "refine.node"]
    assert [issue.value for issue in caught.value.issues] == [2100, 0, 3]


@pytest.mark.parametrize("data", [None, [], "machine", 5])
def test_a_configuration_is_a_section(data: object):
    """Anything but a mapping is refused, an empty file too."""
    with pytest.raises(ConfigError, match=r"\(top level\): must be a section with the keys machine, task and route"):
        parse_config(data)


def test_defaults_fill_what_is_left_out():
    """Options of the stages, tilts and offsets have defaults; those given are kept."""
    data = without("name")
    data.pop("refine", None)
    config = parse_config(data, default_name="from the file")
    assert config.name == "from-the-file"
    assert config.refine == RefineConfig()
    assert config.retime == RetimeConfig()
    assert config.route.follow == FollowConfig()
    assert config.task.start.rx_deg == 0.0
    assert config.machine.links.l1.cart_offset_m == (0.0, 0.0, 0.0)
    assert config.machine.links.l2b.cart_offset_m == (0.0, 0.28, 0.0)
    assert config.machine.links.l3c.length_m is None
    assert config.machine.triangle_branch == "negative"
    assert config.task.locked_axes == ()


def test_limits_of_rules_are_allowed():
    """Values exactly at a bound are fine: a tilt at its limit, a grid of one point, a triangle stretched flat."""
    assert parse_config(with_value("task.start.rx_deg", 30)).task.start.rx_deg == 30.0
    assert parse_config(with_value("route.grid.y_m.max", -0.4)).route.grid.y_m.max == -0.4
    assert parse_config(with_value("machine.links.l3c.length_m", 1.3)).machine.links.l3c.length_m == 1.3
    assert parse_config(with_value("refine", {"nodes": 40, "coefficients": 40})).refine.nodes == 40


def test_the_configuration_cannot_be_changed(agder_config: Config):
    """Sections are frozen."""
    with pytest.raises(ValueError, match="frozen"):
        agder_config.name = "other"


def test_the_default_config_is_the_reference_task(agder_config: Config, quick_config: Config):
    """Both configurations in the repository are valid; the quick one differs in its name and grid alone."""
    assert agder_config.route.grid.y_m.step == 0.06
    assert agder_config.route.step_budget == 25
    assert quick_config.machine == agder_config.machine
    assert quick_config.task == agder_config.task
    assert quick_config.route.grid.y_m.step == 0.1


def test_the_schema_describes_every_key():
    """The JSON schema has descriptions for editors and refuses unknown keys."""
    schema = Config.model_json_schema()
    assert schema["additionalProperties"] is False
    assert schema["required"] == ["machine", "task", "route"]
    assert schema["$defs"]["RailConfig"]["properties"]["y_m"]["description"]


@pytest.mark.parametrize(("text", "expected"), [("on", True), ("off", False), ("yes", True), ("false", False)])
def test_jerk_is_a_switch(text: str, expected: bool) -> None:
    """YAML's words for true and false turn it on and off; on is the default."""
    assert parse_config(with_value("retime.jerk", yaml.safe_load(text))).retime.jerk is expected
    assert parse_config(AGDER).retime.jerk is True


@pytest.mark.parametrize("value", [1, 0, "often", None, [True]])
def test_a_switch_takes_nothing_but_on_and_off(value: object) -> None:
    """Numbers are not switches, and true and false are not numbers."""
    assert messages(with_value("retime.jerk", value))[0].startswith("retime.jerk: is")
    assert "allowed is on or off" in messages(with_value("retime.jerk", value))[0]
    assert "allowed is a number" in messages(with_value("retime.speed", True))[0]


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("machine.limits.carts.jerk_mps3", -40.0, "is -40.0; allowed is a number above 0, at most 100000 or null"),
        (
            "machine.limits.carts.force_n",
            0,
            "is 0; allowed is a number above 0, at most 1e+06 or a section with the keys push, pull or null",
        ),
        ("machine.limits.tcp.speed_mps", -1, "is -1; allowed is a number above 0, at most 20 or null"),
        ("machine.dynamics.platform.inertia_kgm2", [0.1, 0.1, 0.3], "allowed is none larger than the sum of the other"),
        ("machine.dynamics.platform.mass_kg", 0, "is 0; allowed is a number above 0"),
        ("machine.dynamics.friction.carts_n", -2, "is -2; allowed is a number from 0"),
        ("retime.speed", 1.2, "is 1.2; allowed is a number from 1e-06 to 1"),
        ("retime.dwell_s", [1.0], "[1]: is missing; allowed is a number from 0 to 3600"),
        ("export.joint_names", ["a", "a", "b", "c", "d"], "allowed are five different names"),
        ("export.joint_names", ["a b", "a", "b", "c", "d"], "allowed is letters, digits"),
    ],
)
def test_keys_of_motion_are_checked(path: str, value: object, message: str) -> None:
    """Limits, masses, speed and joint names are reported like all other keys."""
    assert message in messages(with_value(path, value))[0]


@pytest.mark.parametrize(("section", "key"), [("carts", "force_n"), ("telescopes", "force_n"), (None, "link_force_n")])
def test_limits_of_forces_need_masses(section: str | None, key: str) -> None:
    """A limit that nothing can be held against is refused, and both keys are named."""
    data = with_value("machine.dynamics", None)
    limits = data["machine"]["limits"]
    for part in (limits["carts"], limits["telescopes"], limits):
        part.pop("force_n", None)
    limits.pop("link_force_n")
    parse_config(data)
    (limits if section is None else limits[section])[key] = 100.0
    (message,) = messages(data)
    assert message.startswith("machine.dynamics: is missing")
    assert f"leave out machine.limits.{f'{section}.' if section else ''}{key}" in message
