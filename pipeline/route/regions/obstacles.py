"""Obstacles on the grid: what is fixed in space cuts the windows of x of the regions."""

from dataclasses import replace
from functools import partial

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.limits.bodies.obstacle_distance import obstacles_of
from pipeline.machine.bodies.intervals import excluded_shifts
from pipeline.machine.geometry import Machine
from pipeline.machine.shapes.model import Bodies
from pipeline.parallel import blocks, in_parallel
from pipeline.route.regions.table import RegionTable

_BLOCK = 2_048
"""Batch size in regions."""


def cut_at_obstacles(config: Config, machine: Machine, regions: RegionTable) -> RegionTable:
    """Leave of every window of x what keeps all bodies apart from all obstacles, one row for each piece of it."""
    pairs = obstacles_of(config)
    if pairs is None or len(regions) == 0:
        return regions
    tasks = [partial(_cut, pairs, machine, regions.take(part)) for part in blocks(len(regions), _BLOCK)]
    return RegionTable.concatenate(list(in_parallel(tasks)))


def excluded_x(pairs: Bodies, machine: Machine, regions: RegionTable) -> FloatArray:
    """Find the interval of x that each pair excludes of n regions, NaN where none. Shape (n, pairs, 2)."""
    x = regions.controlled[:, :1]
    shifts = excluded_shifts(pairs, regions.samples(machine), regions.x_window_m - x)
    return shifts + x[:, None]


def _cut(pairs: Bodies, machine: Machine, regions: RegionTable) -> RegionTable:
    """Cut the windows of a block of regions."""
    excluded = excluded_x(pairs, machine, regions)
    row, windows = pieces(regions.x_window_m, excluded)
    return replace(regions.take(row), x_window_m=windows)


def pieces(windows_m: FloatArray, excluded_m: FloatArray) -> tuple[IntArray, FloatArray]:
    """Give what open intervals (n, p, 2) leave of windows (n, 2): the row of each piece (m,), and the pieces (m, 2)."""
    n = len(windows_m)
    low = np.where(np.isnan(excluded_m[..., 0]), np.inf, excluded_m[..., 0])
    order = np.argsort(low, axis=1, kind="stable")
    low = np.take_along_axis(low, order, axis=1)
    high = np.take_along_axis(np.where(np.isnan(excluded_m[..., 1]), -np.inf, excluded_m[..., 1]), order, axis=1)
    # Between the largest end so far and the next beginning nothing is excluded.
    begins = np.concatenate([np.full((n, 1), -np.inf), np.maximum.accumulate(high, axis=1)], axis=1)
    ends = np.concatenate([low, np.full((n, 1), np.inf)], axis=1)
    first, last = np.maximum(begins, windows_m[:, :1]), np.minimum(ends, windows_m[:, 1:])
    # What has no interval of its own ends where the one before does: an empty piece, or the rest a second time.
    kept = first <= last
    kept[:, 1:] &= (ends[:, 1:] > ends[:, :-1]) | (begins[:, 1:] > begins[:, :-1])
    row, column = np.nonzero(kept)
    return row, np.column_stack([first[row, column], last[row, column]])
