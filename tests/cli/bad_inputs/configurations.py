"""Bad configurations: values of every key, rules between keys, and files that are none."""

import copy
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import yaml

from pipeline.config import Config
from tests.conftest import CONFIGS

WRONG_FOR_EVERY_KEY: dict[str, Any] = {
    "text": "s o o n",
    "nan": math.nan,
    "inf": math.inf,
    "minus infinity": -math.inf,
    "list": [[[1]]],
    "section": {"zz": 1},
    "truth": True,
    "empty": "",
    "most negative": -1e300,
    "date": "2024-01-01",
    "digits": 10**90,
}
"""Values that no key takes; where one is allowed after all, the next is taken."""


class BadConfig(NamedTuple):
    """A configuration as a file, and what the message about it must contain."""

    name: str
    text: str
    expected: tuple[str, ...]


def short() -> dict[str, Any]:
    """Give a configuration in which all is left out that can be."""
    return yaml.load((CONFIGS / "quick.yaml").read_bytes(), Loader=yaml.CSafeLoader)


def complete() -> dict[str, Any]:
    """Give a configuration in which no key is left out."""
    data = short()
    data["task"]["visit"] = [{"box": {"x_m": [0.5, 1.5]}, "modes": ["LLL"]}]
    data["task"]["avoid"] = [{"y_m": [2.0, 3.0]}]
    data["task"]["locked_axes"] = ["rx"]
    return Config.model_validate(data).model_dump(mode="json")


def bad_values() -> Iterator[BadConfig]:
    """Give every key, in turn, one of the values that it does not take."""
    data, base = complete(), short()
    kinds = list(WRONG_FOR_EVERY_KEY)
    for number, path in enumerate(leaves(data)):
        kind = next(k for k in kinds[number % len(kinds) :] + kinds if not _allowed(data, path, k))
        key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)[1:]
        named = key.partition("[")[0] if "[" in key else key
        yield BadConfig(f"{key} {kind}", _dumped(changed(base, path, WRONG_FOR_EVERY_KEY[kind], data)), (named,))


def leaves(data: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """List the keys of a configuration that have values, of a list of sections those of the last."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield from leaves(value, (*path, key))
    elif isinstance(data, list) and data and isinstance(data[0], dict):
        yield from leaves(data[-1], (*path, len(data) - 1))
    else:
        yield path


def _allowed(data: Any, path: tuple[str | int, ...], kind: str) -> bool:
    value = _at(data, path)
    if kind == "truth":
        return isinstance(value, bool)
    return path == ("name",) and kind in ("empty", "date")


def _at(data: Any, path: tuple[str | int, ...]) -> Any:
    for part in path:
        data = data[part]
    return data


def changed(data: Any, path: tuple[str | int, ...], value: Any, full: Any) -> Any:
    """Change one key in a copy; a section that is not there is taken from the full one."""
    data = part = copy.deepcopy(data)
    for depth, key in enumerate(path[:-1], start=1):
        if isinstance(part, dict) and key not in part:
            part[key] = copy.deepcopy(_at(full, path[:depth]))
        part = part[key]
    part[path[-1]] = value
    return data


def _dumped(data: Any) -> str:
    return yaml.dump(data, Dumper=yaml.CSafeDumper, sort_keys=False)


_POSE = {"x_m": 1.02, "y_m": 0.3, "z_m": 0.9, "mode": "LLR"}
_RULES: tuple[tuple[str, Any, str], ...] = (
    ("machine.rails.0.travel_m", [2.1, 0.0], "machine.rails[0].travel_m"),
    ("machine.rails.1.travel_m", [1.0, 1.0], "machine.rails[1].travel_m"),
    ("machine.rails.2.travel_m", [0.0], "machine.rails[2].travel_m"),
    ("machine.rails.2.travel_m", [0.0, 1.0, 2.0], "machine.rails[2].travel_m"),
    ("machine.rails", [], "machine.rails"),
    ("machine.rails", None, "machine.rails"),
    ("machine.links.l2b.stroke_m", [1.25, 0.95], "machine.links.l2b.stroke_m"),
    ("machine.links.l3c.length_m", 9.0, "machine.links.l3c.length_m"),
    ("machine.links.l3c.cart_offset_m", [0.0, 0.1, 0.0], "machine.links.l3c.length_m"),
    ("machine.links.l3c.platform_point_m", [0.0, 0.2, 0.0], "machine.links.l3c.platform_point_m"),
    ("machine.links.l4", {"length_m": 1.0}, "machine.links.l4"),
    ("machine.dynamics", None, "machine.dynamics"),
    ("machine.dynamics.platform.inertia_kgm2", [5.0, 0.1, 0.1], "machine.dynamics.platform.inertia_kgm2"),
    ("machine.limits.carts", {"velocity_mps": 0.5}, "machine.limits.carts.acceleration_mps2"),
    ("task.goal.mode", "lll", "task.goal.mode"),
    ("task.goal.mode", "LLLL", "task.goal.mode"),
    ("task.start", None, "task.start"),
    ("task.start.rx_deg", -31.0, "task.start.rx_deg"),
    ("task.goal.rz_deg", 31.0, "task.goal.rz_deg"),
    ("task.goal", {"x_m": 1.02, "y_m": 0.3, "z_m": 0.9, "mode": "LLL"}, "task.goal"),
    ("task.visit", [{"pose": _POSE, "box": {"x_m": [0.0, 1.0]}}], "task.visit[0]"),
    ("task.visit", [{}], "task.visit[0]"),
    ("task.visit", [{"pose": _POSE, "modes": ["LLL"]}], "task.visit[0].modes"),
    ("task.visit", [{"box": {}}], "task.visit[0].box"),
    ("task.visit", [{"box": {"z_m": [1.0, 0.5]}}], "task.visit[0].box.z_m"),
    ("task.visit", [{"box": {"x_m": [0.0, 1.0]}}] * 101, "101 entries"),
    ("task.avoid", [{"x_m": [0.0, 0.1]}] * 201, "201 entries"),
    ("task.avoid", [{"x_m": [1.0, 1.1]}], "task.avoid[0]"),
    ("task.avoid", {"x_m": [1.0, 1.1]}, "task.avoid"),
    ("task.locked_axes", ["rx", "rx"], "task.locked_axes"),
    ("task.locked_axes", ["ry"], "task.locked_axes[0]"),
    ("task.tilt_max_deg", -1e-9, "task.tilt_max_deg"),
    ("task.budget.travel_m", 0, "task.budget.travel_m"),
    ("task.budget.mode_changes", 1.5, "task.budget.mode_changes"),
    ("route.grid.y_m", {"min": 1.0, "max": 0.0, "step": 0.1}, "route.grid.y_m.max"),
    ("route.grid.y_m.step", 1e-6, "route.memory_gb allows"),
    ("route.grid.z_m.step", 1e-9, "route.grid.z_m.step"),
    ("route.grid.z_m.step", 5e-324, "route.grid.z_m.step"),
    ("route.grid.rx_step_deg", 1e-300, "route.grid.rx_step_deg"),
    ("route.grid.rz_step_deg", 5e-324, "route.grid.rz_step_deg"),
    ("route.memory_gb", 1e-12, "route.memory_gb allows 1e-12"),
    ("route.step_budget", 1, "route.step_budget"),
    ("route.step_budget", 10**30, "route.step_budget"),
    ("route.alternative", 0, "route.alternative"),
    ("route.follow", [], "route.follow"),
    ("refine.coefficients", 399, "refine.coefficients"),
    ("refine.start_direction", [0, 0, 0], "refine.start_direction"),
    ("refine.goal_direction", [1, 0], "refine.goal_direction"),
    ("refine.approach_m", 0.05, "refine.approach_m"),
    ("retime.speed", 5e-324, "retime.speed"),
    ("retime.dwell_s", [-1, 0], "retime.dwell_s[0]"),
    ("certify.what", False, "in quotes"),
    ("export.joint_names", ["c1", "c2", "c3", False, True], "in quotes"),
    ("export.joint_names", ["c1", "c1", "c2", "l2b", "l3b"], "export.joint_names"),
    ("export.joint_names", ["c1", "c2", "c3", "l2b", "x" * 101], "at most 100"),
    ("export.joint_names", ["c1", "c2", "c3", "l2b", "\x1b[31m"], "export.joint_names[4]"),
    ("name", "x" * 61, "at most 60"),
    ("name", "../up", "name"),
    ("name", "a\nb", "name"),
    ("\x1b]0;title", 1, "\\x1b]0;title: is not a known key"),
)


def broken_rules() -> Iterator[BadConfig]:
    """Break rules between keys, and give numbers that are too large or too small to be counted."""
    data, base = complete(), short()
    for key, value, expected in _RULES:
        path = tuple(int(part) if part.isdecimal() else part for part in key.split("."))
        yield BadConfig(f"{key!r} {str(value)[:30]!r}", _dumped(changed(base, path, value, data)), (expected,))


_MULTIPLIED = "a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n" + "".join(
    f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join(['*' + chr(97 + k)] * 10)}]\n" for k in range(9)
)
_TEXTS = {
    "": "machine, task and route",
    "~": "machine, task and route",
    "machine": "machine, task and route",
    "- machine": "machine, task and route",
    "name: x": "machine: is missing",
    "name: &a [*a]": "*a is a part of itself",
    "a: &a {b: *a}": "*a is a part of itself",
    "x: &x {<<: *x}": "*x is a part of itself",
    "name: !!int ''": "'' is not a value of the type int",
    "name: !!float ''": "'' is not a value of the type float",
    "name: !!bool maybe": "'maybe' is not a value of the type bool",
    "name: !!timestamp soon": "'soon' is not a value of the type timestamp",
    "name: 2024-13-45": "month must be in 1..12",
    "name: " + "9" * 20_000: "20,000 characters; allowed are 100",
    "name: 0x" + "f" * 20_000: "20,002 characters",
    "name: 1" + ":59" * 20_000: "60,001 characters",
    "[" * 500 + "]" * 500: "more than 32 deep",
    "[" * 10_000: "more than 32 deep",
    "- " * 10_000: "more than 32 deep",
    "{a: " * 40 + "1" + "}" * 40: "more than 32 deep",
    _MULTIPLIED + "name: *j": "more than 50,000 keys and values",
    _MULTIPLIED + "task: {avoid: *j}": "more than 50,000 keys and values",
    "k: 1\n" * 500: "the key 'k' is given twice",
    "".join(f"k{k}: 1\n" for k in range(1_500)): "more",
    "on: 1": "YAML reads the key 'on' as a truth value",
    "export: {no: 1}": "YAML reads the key 'no' as a truth value",
    "1: 2": "YAML reads the key '1' as a number",
    "~: 2": "YAML reads the key '~' as nothing",
    "2020-01-01: 1": "YAML reads the key '2020-01-01' as a date",
    "? [a]\n: 1": "a list or section cannot be a key",
    "? {a: 1}\n: 1": "a list or section cannot be a key",
    "name: *nothing": "found undefined alias",
    "a: 1\n---\nb: 2": "single document",
    "name: !!python/object:os.system {}": "could not determine a constructor",
    "name: !tag x": "could not determine a constructor",
    "%YAML 9.9\n---\na: 1": "incompatible YAML document",
    "name: \x07": "has a control character",
    '"\\ud800": 1': "\\ud800",
    'name: "\\ud800"': "\\ud800",
    'name: "\\e[31m"': "name: is",
    "name: !!set {a, b}": "name: is",
    "name: !!omap [a: 1]": "name: is",
    "<<: 1": "expected a mapping",
    "#" * 1_000_001: "at most 1,000,000 are read",
    "x" * 90_000: "machine, task and route",
    "machine: [\n" + "  {a: 1},\n" * 500 + "]": "machine",
}


def no_configurations() -> Iterator[BadConfig]:
    """Give texts that are no YAML, too much of it, or YAML of something else."""
    for text, expected in _TEXTS.items():
        yield BadConfig(repr(text[:24]), text, (expected,))
