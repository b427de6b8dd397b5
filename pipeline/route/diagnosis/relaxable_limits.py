"""The limits that can stand in a route's way, and the milder values of each that are worth trying.

A table built with the mildest value holds the regions of all the others: cutting it down to a value gives the
table that `build_regions` would compute with it, so that one table and its moves serve a whole bisection.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.config import Config
from pipeline.machine.clearance import min_distances
from pipeline.machine.geometry import Machine
from pipeline.route.diagnosis.result import TRAVEL
from pipeline.route.regions.table import RegionTable

_ROUNDING = 1e-9
_TILT_BOUND_DEG = 45.0
_LARGEST_TILT_DEG = 85.0
_KAPPA_BOUND, _KAPPA_PER_DECADE = 1_000.0, 1_000
_CLEARANCE_STEP_M = 1e-4
_TRAVEL_STEP_M, _TRAVEL_COUNT = 1e-3, 1_000

RegionFilter = Callable[[float], tuple[RegionTable, BoolArray]]
"""Gives, for a value, the regions (windows of x adapted) and which of them the value admits."""


@dataclass(frozen=True, eq=False)
class RelaxableLimit:
    """A limit that may stand in the way.

    Attributes
    ----------
    key : str
        Its path in the configuration.
    configured : float
        Its value there.
    levels : (n,)
        A value known not to be enough, then values to try, each milder than the one before.
    segments : tuple of int
        Ends of the parts of `levels` that are looked at one after the other, each with a table of its own.
    change : callable
        The configuration with a value.
    prepare : callable
        Makes the `RegionFilter` of a table built with a value, for the machine as configured.
    locked_axes : tuple of str or None
        Tilt axes still locked, where the change is to unlock others.
    """

    key: str
    configured: float
    levels: FloatArray
    segments: tuple[int, ...]
    change: Callable[[float], Config]
    prepare: Callable[[RegionTable], RegionFilter]
    locked_axes: tuple[str, ...] | None = None


def relaxable_limits(config: Config, machine: Machine) -> list[RelaxableLimit]:
    """List the limits that could give, leaving out those that refuse nothing."""
    found = [*_tilt(config), _kappa(config), *_clearances(config, machine), _travel(config, machine)]
    return [obstacle for obstacle in found if len(obstacle.levels) > 1]


def not_varied(config: Config) -> list[str]:
    """Say what else the task asks for that is no limit looked at here."""
    task = config.task
    asked = [f"task.budget.{key} {value:g}" for key, value in task.budget if value is not None]
    asked += [f"task.{key} ({len(many)})" for key, many in (("avoid", task.avoid), ("visit", task.visit)) if many]
    return [f"also asked for, and not varied here: {', '.join(asked)}"] if asked else []


def _tilt(config: Config) -> list[RelaxableLimit]:
    """The tilt limit with the axes locked as configured, then with each and all of the locked ones free."""
    locked = tuple(config.task.locked_axes)
    found = [_tilt_with(config, locked)] if len(locked) < 2 else []
    kept = [tuple(axis for axis in locked if axis != free) for free in locked] + [()]
    return found + [_tilt_with(config, axes) for axes in dict.fromkeys(kept) if axes != locked]


def _tilt_with(config: Config, locked: tuple[str, ...]) -> RelaxableLimit:
    task, grid, unlocks = config.task, config.route.grid, locked != tuple(config.task.locked_axes)
    # Poses given may be tilted: less than that is no value of the key, and with as much a freed axis may do.
    poses = [task.start, task.goal, *(visit.pose for visit in task.visit if visit.pose is not None)]
    given = max(abs(tilt) for pose in poses for tilt in (pose.rx_deg, pose.rz_deg))
    least = given if unlocks else task.tilt_max_deg
    bound = _TILT_BOUND_DEG if task.tilt_max_deg < _TILT_BOUND_DEG else _LARGEST_TILT_DEG
    steps = [step for axis, step in (("rx", grid.rx_step_deg), ("rz", grid.rz_step_deg)) if axis not in locked]
    multiples = np.concatenate([step * np.arange(1, int(bound / step + _ROUNDING) + 1) for step in steps])
    refused = 0.0 if unlocks else least
    levels = np.unique([refused, least, *multiples[multiples > least + _ROUNDING].round(9)])

    def change(value: float) -> Config:
        return _with(config, "task", tilt_max_deg=value, locked_axes=locked)

    def prepare(wide: RegionTable) -> RegionFilter:
        tilt = np.abs(wide.controlled[:, 3:]).max(axis=1)
        return lambda value: (wide, tilt <= np.deg2rad(value) + _ROUNDING)

    return RelaxableLimit(
        key="task.tilt_max_deg",
        configured=task.tilt_max_deg,
        levels=levels,
        segments=_doubling(len(levels)),
        change=change,
        prepare=prepare,
        locked_axes=locked if unlocks else None,
    )


def _doubling(count: int) -> tuple[int, ...]:
    """Ends of parts that double: tables grow with the square of the tilt, and the least may do."""
    ends = [2**k for k in range(1, 10) if 2**k < count]
    return (*ends, count)


def _kappa(config: Config) -> RelaxableLimit:
    configured = config.route.kappa_max
    whole = np.arange(np.floor(configured) + 1.0, _KAPPA_BOUND + 0.5)
    top, bound = max(_KAPPA_BOUND, configured), 10.0 * configured
    count = int(np.ceil(_KAPPA_PER_DECADE * np.log10(max(bound / top, 1.0))))
    levels = np.array([configured, *whole, *np.geomspace(top, max(bound, top), count + 1)[1:]])

    def prepare(wide: RegionTable) -> RegionFilter:
        return lambda value: (wide, wide.kappa < value)

    return RelaxableLimit(
        "route.kappa_max",
        configured,
        levels,
        (len(levels),),
        lambda value: _with(config, "route", kappa_max=value),
        prepare,
    )


def _clearances(config: Config, machine: Machine) -> list[RelaxableLimit]:
    def links(wide: RegionTable) -> FloatArray:
        return wide.link_distance_m

    def rails(wide: RegionTable) -> FloatArray:
        return min_distances(machine, wide.pose, wide.q_m[:, :3])[1]

    found = [_clearance(config, "link_link_m", links)]
    if config.machine.clearance.link_rail_m is not None:
        found.append(_clearance(config, "link_rail_m", rails))
    return found


def _clearance(config: Config, name: str, measure: Callable[[RegionTable], FloatArray]) -> RelaxableLimit:
    configured = getattr(config.machine.clearance, name)
    count = int(np.ceil(configured / _CLEARANCE_STEP_M - _ROUNDING))
    levels = np.array([configured, *(_CLEARANCE_STEP_M * np.arange(count - 1, -1, -1)).round(9)])

    def change(value: float) -> Config:
        clearance = config.machine.clearance.model_copy(update={name: value})
        return _with(config, "machine", clearance=clearance)

    def prepare(wide: RegionTable) -> RegionFilter:
        distance = measure(wide)
        return lambda value: (wide, ~(distance < value))

    return RelaxableLimit(f"machine.clearance.{name}", configured, levels, (len(levels),), change, prepare)


def _travel(config: Config, machine: Machine) -> RelaxableLimit:
    """All rails longer at both ends."""
    levels = np.array([k * _TRAVEL_STEP_M for k in range(_TRAVEL_COUNT + 1)]).round(9)

    def change(value: float) -> Config:
        rails = []
        for rail in config.machine.rails:
            least, largest = rail.travel_m
            rails.append(rail.model_copy(update={"travel_m": (least - value, largest + value)}))
        return _with(config, "machine", rails=tuple(rails))

    def prepare(wide: RegionTable) -> RegionFilter:
        carts = wide.q_m[:, :3] - wide.controlled[:, :1]
        least, largest = (machine.travel_m[:, 0] - carts).max(axis=1), (machine.travel_m[:, 1] - carts).min(axis=1)
        return lambda value: _narrowed(wide, least - value, largest + value)

    return RelaxableLimit(TRAVEL, 0.0, levels, (len(levels),), change, prepare)


def _narrowed(wide: RegionTable, least_m: FloatArray, largest_m: FloatArray) -> tuple[RegionTable, BoolArray]:
    """Cut the windows of x down to what the carts' travel allows, [least, largest] (n,) each."""
    low, high = np.maximum(wide.x_window_m[:, 0], least_m), np.minimum(wide.x_window_m[:, 1], largest_m)
    # Poses with an x of their own are on the rails; rounding must not throw them off.
    own = wide.x_window_m[:, 0] == wide.x_window_m[:, 1]
    windows = np.where(own[:, None], wide.x_window_m, np.column_stack([low, high]))
    return replace(wide, x_window_m=windows), windows[:, 0] <= windows[:, 1]


def _with(config: Config, section: str, **values: Any) -> Config:
    return config.model_copy(update={section: getattr(config, section).model_copy(update=values)})
