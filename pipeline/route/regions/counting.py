"""What a task asks for that no route can do, by counting alone: known before any region is computed.

A move changes no coordinate by more than its largest step (13)-(17), and the working mode of one arm at most, on
leaving its gate (38); the start, the goal and poses to visit are no gates. Between these, and through the boxes to
visit in their order, every coordinate travels at least as far as a taut string does.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config, PoseConfig
from pipeline.errors import ConfigError, ConfigIssue
from pipeline.limits.actuator_margins import controlled_pose
from pipeline.limits.approach import between_approaches
from pipeline.limits.avoid import ROUNDING, Box
from pipeline.machine.geometry import MODES, Machine
from pipeline.route.metric import step_sizes
from pipeline.route.regions.boxes import grown_boxes
from pipeline.route.regions.endpoints import Endpoint, task_endpoints
from pipeline.route.regions.grid import grid_axes

_KEYS = ("x_m", "y_m", "z_m", "rx_deg", "rz_deg")
_POSITIONS, _TILTS = slice(0, 3), slice(3, 5)


@dataclass(frozen=True, eq=False)
class _Station:
    """Where a route has to be: anywhere between two controlled poses (5,), in one of some working modes."""

    name: str
    low: FloatArray
    high: FloatArray
    modes: tuple[int, ...]
    is_pose: bool


def require_possible_task(config: Config, machine: Machine) -> tuple[Endpoint, Endpoint]:
    """Place the machine at start and goal, and count: everything that is known to be impossible, at once.

    Raises
    ------
    ConfigError
        For the reasons of `task_endpoints`, and when the task asks for what is impossible by counting.
    """
    issues = counting_issues(between_approaches(config))
    try:
        ends = task_endpoints(config, machine)
    except ConfigError as error:
        raise ConfigError([*error.issues, *issues]) from None
    if issues:
        raise ConfigError(issues)
    return ends


def counting_issues(config: Config) -> list[ConfigIssue]:
    """Name every key that asks for what is impossible by counting."""
    stations = _stations(config)
    issues = _outside(config)
    if issues:
        # A box without regions has no way through it to count.
        return issues + _walls(config, stations)
    task, budget = config.task, config.task.budget
    changes = _least_changes(stations)
    if budget.mode_changes is not None and budget.mode_changes < changes:
        route = " over its visits" if task.visit else ""
        issues.append(
            ConfigIssue(
                "task.budget.mode_changes",
                f"is {budget.mode_changes}; from {task.start.mode} to {task.goal.mode}{route} takes at least "
                f"{changes}, one arm at a time",
            )
        )
    travel = _least_travel(stations)
    tilt = float(np.rad2deg(travel[_TILTS].sum()))
    for key, allowed, least, what in (
        ("travel_m", budget.travel_m, float(travel[_POSITIONS].sum()), "the straight way, along X, Y and Z together"),
        ("tilt_deg", budget.tilt_deg, tilt, "the straight way, in rx and rz together"),
    ):
        if allowed is not None and allowed < least - ROUNDING:
            issues.append(ConfigIssue(f"task.budget.{key}", f"is {allowed:g}; {what}, takes {_up(least)} at least"))
    return issues + _too_few_positions(config, stations) + _walls(config, stations)


def _stations(config: Config) -> list[_Station]:
    """List start, visits and goal; boxes to visit as far as the grid has anything there."""
    task = config.task
    low, high = _grid_range(config)
    found = [_at("the start", task.start)]
    for k, visit in enumerate(task.visit):
        name = f"task.visit[{k}]"
        if visit.pose is not None:
            found.append(_at(name, visit.pose))
        elif visit.box is not None:
            box = Box.of(visit.box)
            modes = tuple(MODES.index(mode) for mode in visit.modes) or tuple(range(len(MODES)))
            found.append(_Station(name, np.maximum(box.low, low), np.minimum(box.high, high), modes, is_pose=False))
    return [*found, _at("the goal", task.goal)]


def _at(name: str, pose: PoseConfig) -> _Station:
    place = controlled_pose(pose)
    return _Station(name, place, place, (MODES.index(pose.mode),), is_pose=True)


def _grid_range(config: Config) -> tuple[FloatArray, FloatArray]:
    """Give the least and largest x (endless), y, z, rx, rz of regions, gates included. Shapes (5,)."""
    axes = grid_axes(config)
    return np.array([-np.inf, *(axis[0] for axis in axes)]), np.array([np.inf, *(axis[-1] for axis in axes)])


def _outside(config: Config) -> list[ConfigIssue]:
    """Refuse boxes to visit where the grid has nothing, or that lie within a box to avoid."""
    low, high = _grid_range(config)
    issues = []
    for k, visit in enumerate(config.task.visit):
        if visit.box is None:
            continue
        box = Box.of(visit.box)
        for axis in np.flatnonzero((box.low > high + ROUNDING) | (box.high < low - ROUNDING)).tolist():
            least, most = (_shown(axis, value) for value in (low[axis], high[axis]))
            asked = list(getattr(visit.box, _KEYS[axis]))
            issues.append(
                ConfigIssue(
                    f"task.visit[{k}].box.{_KEYS[axis]}", f"is {asked}, off the grid, which has {least} to {most}"
                )
            )
        for number, avoided in enumerate(grown_boxes(config)):
            within = np.isneginf(avoided.low) | (box.low > avoided.low + ROUNDING)
            within &= np.isposinf(avoided.high) | (box.high < avoided.high - ROUNDING)
            if within.all():
                issues.append(ConfigIssue(f"task.visit[{k}].box", f"lies within task.avoid[{number}] and its margin"))
    return issues


def _least_travel(stations: list[_Station]) -> FloatArray:
    """Compute how far each coordinate travels at least: a string pulled taut through all intervals. Shape (5,)."""
    low, high, travelled = stations[0].low, stations[0].high, np.zeros(5)
    for station in stations[1:]:
        travelled = travelled + np.maximum(low - station.high, 0.0) + np.maximum(station.low - high, 0.0)
        low, high = np.clip(low, station.low, station.high), np.clip(high, station.low, station.high)
    return travelled


def _least_changes(stations: list[_Station]) -> int:
    """Count the changes of working mode that cannot be avoided: a dynamic program over the modes of the stations."""
    least = dict.fromkeys(stations[0].modes, 0)
    for station in stations[1:]:
        least = {
            mode: min(count + (mode ^ before).bit_count() for before, count in least.items()) for mode in station.modes
        }
    return min(least.values())


def _too_few_positions(config: Config, stations: list[_Station]) -> list[ConfigIssue]:
    """Refuse a step budget below what the ways from pose to pose take, one after the other."""
    steps = step_sizes(config.route)
    poses = [k for k, station in enumerate(stations) if station.is_pose]
    needed, reasons = 1, []
    for first, last in pairwise(poses):
        way = stations[first : last + 1]
        counted = np.ceil(_least_travel(way) / steps - ROUNDING).astype(int)
        axis, changes = int(counted.argmax()), _least_changes(way)
        moves, why = max(
            (last - first, "a move for each visit"),
            (changes + 1 if changes else 0, f"{changes} changes of working mode, one a move, none on leaving a pose"),
            (int(counted[axis]), f"{_KEYS[axis].rpartition('_')[0]} changes by at most one grid step a move"),
        )
        needed += moves
        reasons.append(f"{moves} moves from {way[0].name} to {way[-1].name} ({why})")
    if config.route.step_budget >= needed:
        return []
    reason = f"is {config.route.step_budget}; at least {needed} positions are needed: {', '.join(reasons)}"
    return [ConfigIssue("route.step_budget", reason)]


def _walls(config: Config, stations: list[_Station]) -> list[ConfigIssue]:
    """Refuse boxes to avoid that stand between two poses and reach across everything: there is no way round them."""
    low, high = _grid_range(config)
    poses = [station for station in stations if station.is_pose]
    low = np.min([low, *(pose.low for pose in poses)], axis=0)
    high = np.max([high, *(pose.high for pose in poses)], axis=0)
    issues = []
    for k, box in enumerate(grown_boxes(config)):
        across = (np.isneginf(box.low) | (box.low < low - ROUNDING)) & (
            np.isposinf(box.high) | (box.high > high + ROUNDING)
        )
        if across.sum() != 4:
            continue
        axis = int(np.flatnonzero(~across)[0])
        for here, there in pairwise(poses):
            near, far = sorted((here.low[axis], there.low[axis]))
            if near <= box.low[axis] + ROUNDING and far >= box.high[axis] - ROUNDING:
                asked = list(getattr(config.task.avoid[k], _KEYS[axis]))
                issues.append(
                    ConfigIssue(
                        f"task.avoid[{k}].{_KEYS[axis]}",
                        f"is {asked}, a wall between {here.name} and {there.name}: the box leaves no way round it",
                    )
                )
    return issues


def _shown(axis: int, value: float) -> str:
    return f"{np.rad2deg(value) if axis >= _TILTS.start else value:g}"


def _up(value: float) -> str:
    """Format a least value so that rounding does not lower it."""
    return f"{np.ceil(value * 1e4 - ROUNDING) / 1e4:g}"
