"""Changes of a configuration from the page: each gives a new one, checked as a file is."""

from collections.abc import Mapping
from typing import Any

from pipeline.config import Config, PoseConfig
from pipeline.config.file import parse_config
from pipeline.errors import ConfigError, UsageError
from pipeline.machine.geometry import Machine
from pipeline.route.checked_task import require_sound_task

_PAGE = "this change"


def with_end(config: Config, end: str, pose: PoseConfig) -> Config:
    """Set the start or the goal."""
    return _with_task(config, {end: pose.model_dump(mode="json")})


def with_visit(config: Config, pose: PoseConfig) -> Config:
    """Add a pose to visit, after the others."""
    return _with_task(config, {"visit": [*_task(config)["visit"], {"pose": pose.model_dump(mode="json")}]})


def with_box(config: Config, box: Mapping[str, tuple[float, float]]) -> Config:
    """Add a box to avoid: [least, largest] by `x_m`, `y_m`, `z_m`, `rx_deg`, `rz_deg`; others may have any value."""
    return _with_task(config, {"avoid": [*_task(config)["avoid"], {key: list(ends) for key, ends in box.items()}]})


def box_around(pose: PoseConfig, size_m: tuple[float, float, float], any_x: bool) -> dict[str, tuple[float, float]]:
    """Give the box of a size with the TCP of a pose in its middle, along x as long as it likes if `any_x`."""
    middle = {"x_m": pose.x_m, "y_m": pose.y_m, "z_m": pose.z_m}
    sides = zip(middle.items(), size_m, strict=True)
    ends = {key: (round(value - side / 2.0, 4), round(value + side / 2.0, 4)) for (key, value), side in sides}
    return {key: interval for key, interval in ends.items() if not (any_x and key == "x_m")}


def without(config: Config, entry: str) -> Config:
    """Remove an entry by its name, such as `visit[0]` or `avoid[2]`.

    Raises
    ------
    UsageError
        For the start and the goal, which every task has.
    """
    key, index = _entry(entry)
    if index is None:
        raise UsageError(f"the {key} can be moved, not removed: go to another pose and take that")
    entries = _task(config)[key]
    return _with_task(config, {key: entries[:index] + entries[index + 1 :]})


def task_pose(config: Config, entry: str) -> PoseConfig:
    """Give the pose of `start`, `goal` or a visit such as `visit[0]`.

    Raises
    ------
    UsageError
        For a box, which has none.
    """
    key, index = _entry(entry)
    if index is None:
        return config.task.start if key == "start" else config.task.goal
    pose = config.task.visit[index].pose if key == "visit" else None
    if pose is None:
        raise UsageError(f"{entry} is a box: it has no pose to go to")
    return pose


def _entry(name: str) -> tuple[str, int | None]:
    key, _, rest = name.partition("[")
    return key, int(rest.rstrip("]")) if rest else None


def with_machine(config: Config, values: Mapping[str, object]) -> Config:
    """Set values of the machine by their keys below `machine`, such as `rails.0.travel_m`.

    Raises
    ------
    ConfigError
        When they are not allowed; names every key.
    """
    data = config.model_dump(mode="json")
    for path, value in values.items():
        *sections, key = path.split(".")
        part: Any = data["machine"]
        for name in sections:
            part = part[int(name) if name.isdecimal() else name]
        part[key] = value
    return parse_config(data, source=_PAGE)


def machine_value(config: Config, path: str) -> Any:
    """Give a value of the machine by its key below `machine`."""
    part: Any = config.machine
    for name in path.split("."):
        part = part[int(name)] if name.isdecimal() else getattr(part, name)
    return part


def task_refusals(config: Config, machine: Machine) -> list[str]:
    """State what `check` would refuse of the whole task; empty if it can be planned."""
    try:
        require_sound_task(config, machine)
    except ConfigError as error:
        return [str(issue) for issue in error.issues]
    return []


def _task(config: Config) -> dict[str, Any]:
    return config.task.model_dump(mode="json")


def _with_task(config: Config, values: dict[str, Any]) -> Config:
    data = config.model_dump(mode="json")
    data["task"] |= values
    return parse_config(data, source=_PAGE)
