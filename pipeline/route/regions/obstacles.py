"""Obstacles on the grid: what is fixed in space cuts the windows of x of the regions."""

from dataclasses import replace
from functools import partial

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.limits.bodies.obstacle_distance import obstacles_of
from pipeline.machine.bodies.intervals import excluded_shifts, free_pieces
from pipeline.machine.geometry import Machine
from pipeline.machine.shapes.model import Bodies
from pipeline.parallel import blocks, in_parallel
from pipeline.route.regions.table import RegionTable

_BLOCK = 2_048
"""Batch size in regions."""


def cut_at_obstacles(config: Config, machine: Machine, regions: RegionTable) -> RegionTable:
    """Leave of every window of x what keeps all bodies apart from all obstacles, one row for each piece of it.

    Intervals are wider by `route.avoid_margin` steps along X, since a followed move bulges.
    """
    pairs = obstacles_of(config)
    if pairs is None or len(regions) == 0:
        return regions
    margin_m = config.route.avoid_margin * config.route.x_step_m
    tasks = [partial(_cut, pairs, machine, regions.take(part), margin_m) for part in blocks(len(regions), _BLOCK)]
    return RegionTable.concatenate(list(in_parallel(tasks)))


def excluded_x(pairs: Bodies, machine: Machine, regions: RegionTable) -> FloatArray:
    """Find the interval of x that each pair excludes of n regions, NaN where none. Shape (n, pairs, 2)."""
    x = regions.controlled[:, :1]
    shifts = excluded_shifts(pairs, regions.samples(machine), regions.x_window_m - x)
    return shifts + x[:, None]


def _cut(pairs: Bodies, machine: Machine, regions: RegionTable, margin_m: float) -> RegionTable:
    """Cut the windows of a block of regions."""
    excluded = excluded_x(pairs, machine, regions) + [-margin_m, margin_m]
    row, windows = free_pieces(regions.x_window_m, excluded)
    return replace(regions.take(row), x_window_m=windows)
