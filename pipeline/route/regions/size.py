"""How large the region table of a configuration becomes, before it is computed."""

import math
from dataclasses import dataclass

import numpy as np

from pipeline.config import Config
from pipeline.errors import ConfigError, ConfigIssue, UnfitConfigError
from pipeline.machine.geometry import MODES, Machine
from pipeline.machine.rails import with_parallel_rails
from pipeline.route.memory import POINT_BYTES, memory_gb
from pipeline.route.metric import step_sizes
from pipeline.route.regions.boxes import cut_windows, grown_boxes
from pipeline.route.regions.build import admissible_regions, regions_at
from pipeline.route.regions.gates import gates_beside
from pipeline.route.regions.grid import COUNTABLE, grid_shape, points_at
from pipeline.route.regions.table import RegionTable
from pipeline.route.regions.task_rows import rows_to_visit

_SAMPLE = 2_048
"""Grid points whose regions are computed for an estimate."""
_MOVES_PER_REGION = 65
"""Of the 80 neighbours in a grid of four axes, those admitted: 52 to 73 on the grids measured."""
_SURE = 0.8
"""Part of an estimate that is needed for certain; what lies above is left to the exact count."""


@dataclass(frozen=True)
class TableSize:
    """What a configuration takes: grid points, and about how many regions, moves and gigabytes."""

    points: int
    regions: float
    moves: float
    memory_gb: float


def require_grid_fits(config: Config) -> None:
    """Refuse a grid whose points alone take up more memory than allowed; costs nothing.

    Raises
    ------
    ConfigError
        With the key of the axis that has most points.
    """
    shape, grid = grid_shape(config), config.route.grid
    points, allowed = math.prod(shape), config.route.memory_gb
    if points * POINT_BYTES <= allowed * 1e9:
        return
    keys = ("y_m.step", "z_m.step", "rx_step_deg", "rz_step_deg")
    steps = (grid.y_m.step, grid.z_m.step, grid.rx_step_deg, grid.rz_step_deg)
    count, key, step = max(zip(shape, keys, steps, strict=True))
    least = "at least " if max(shape) > COUNTABLE else ""
    raise ConfigError(
        [
            ConfigIssue(
                f"route.grid.{key}",
                f"is {step!r}, which makes {least}{count:,} values of this axis and {points:.3g} grid points in all: "
                f"{least}{points * POINT_BYTES / 1e9:,.2f} GB of memory for these alone; route.memory_gb allows "
                f"{allowed:g}. Take a larger step, or allow more where there is as much",
                step,
            )
        ]
    )


def require_table_fits(config: Config, machine: Machine) -> None:
    """Refuse a table that will certainly not fit, before it is computed; takes a fraction of a second.

    Raises
    ------
    UnfitConfigError
        When regions, moves and shortest paths would take up more than `route.memory_gb`.
    """
    points, allowed = math.prod(grid_shape(config)), config.route.memory_gb
    most = points * POINT_BYTES / 1e9
    repeated = 2 + len(config.task.visit) + 2 * (len(config.task.avoid) + len(config.task.obstacles))
    if most <= allowed and memory_gb(1.0, repeated * _MOVES_PER_REGION) * repeated**2 * len(MODES) * points <= allowed:
        return
    size = expected_size(config, machine) if most <= allowed else TableSize(points, 0.0, 0.0, most / _SURE)
    if _SURE * size.memory_gb > allowed:
        raise UnfitConfigError(
            "regions",
            f"route.grid has {points:,} points, with the task about {size.regions:,.0f} regions and {size.moves:,.0f} "
            f"moves, which take up about {size.memory_gb:,.2f} GB of memory; route.memory_gb allows {allowed:g}",
            f"set route.memory_gb to {1.2 * size.memory_gb:.2f} where there is as much, or coarsen route.grid: twice "
            "the tilt steps make a quarter of the regions" + _advice(config),
            {"points": points, "expected_regions": size.regions, "expected_memory_gb": size.memory_gb},
        )


def expected_size(config: Config, machine: Machine) -> TableSize:
    """Estimate regions, moves and memory from a sample of the grid, the same each time; within some 20 percent."""
    machine = with_parallel_rails(machine)
    points = math.prod(grid_shape(config))
    count = min(points, _SAMPLE)
    numbers = (np.arange(count) + np.random.default_rng(0).random(count)) * (points / count)
    some = points_at(config, numbers.astype(np.int64))
    gates = admissible_regions(config, machine, *gates_beside(config, machine, some))
    sample = RegionTable.concatenate([regions_at(config, machine, some), gates])
    cut = cut_windows(grown_boxes(config), sample, step_sizes(config.route)) if config.task.avoid else sample
    visits = [len(rows_to_visit(cut, visit)) for visit in config.task.visit if visit.box is not None]
    scale = points / count
    rows = scale * (len(cut) + sum(visits))
    # Rows that repeat a region are neighbours of one another, and every state of the visits has all of them again.
    moves = _MOVES_PER_REGION * rows * (len(cut) + sum(visits)) / max(len(sample), 1)
    graphs = 1 if not config.task.visit else 2 + len(config.task.visit)
    return TableSize(points, rows, moves, memory_gb(rows * graphs, moves * graphs) + points * 40 / 1e9)


def _advice(config: Config) -> str:
    many = [f"task.{key}" for key in ("visit", "avoid") if len(getattr(config.task, key)) > 1]
    return f"; or leave out some of {' and '.join(many)}" if many else ""
