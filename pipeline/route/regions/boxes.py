"""Boxes to avoid on the grid: regions near them, and the moves between these.

x is not a grid axis, so a box to avoid cuts the windows of x of the regions beside it. A move between two cut
regions is clear when both are on the same side of the box along X, or when the line between them in y, z, rx, rz
passes the box by: whatever x does, no pose of the line is then inside.
"""

from dataclasses import replace

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import Config
from pipeline.limits.avoid import ROUNDING, Box, boxes_to_avoid
from pipeline.parallel import blocks
from pipeline.route.metric import step_sizes
from pipeline.route.regions.table import RegionTable

_BLOCK = 200_000
"""Batch size in moves."""


def grown_boxes(config: Config) -> list[Box]:
    """Read `task.avoid`, grown by `route.avoid_margin`: for regions, since a followed move bulges."""
    margin = config.route.avoid_margin * step_sizes(config.route)
    return [box.grown(margin) for box in boxes_to_avoid(config)]


def cut_windows(boxes: list[Box], regions: RegionTable, steps: FloatArray) -> RegionTable:
    """Cut the windows of x at every box within one of `steps` (5,), and leave out what is inside.

    A region may become several rows, one for each piece of its window.
    """
    for box in boxes:
        near = np.flatnonzero(box.near(regions.controlled, steps))
        within = box.across().inside(regions.controlled[near])
        pieces = [
            _piece(regions, near, -np.inf, box.low[0]),
            _piece(regions, near[~within], box.low[0], box.high[0]),
            _piece(regions, near, box.high[0], np.inf),
        ]
        rest = np.ones(len(regions), dtype=bool)
        rest[near] = False
        regions = RegionTable.concatenate([regions.take(rest), *pieces])
    return regions


def _piece(regions: RegionTable, rows: IntArray, low_m: float, high_m: float) -> RegionTable:
    part = regions.take(rows)
    windows = np.column_stack([np.maximum(part.x_window_m[:, 0], low_m), np.minimum(part.x_window_m[:, 1], high_m)])
    return replace(part, x_window_m=windows).take(windows[:, 0] <= windows[:, 1])


def crossings(
    boxes: list[Box], regions: RegionTable, steps: FloatArray, source: IntArray, target: IntArray
) -> BoolArray:
    """Tell which moves between rows (m,) could pass through a box for some x within their windows. Shape (m,).

    No move is longer than `steps` (5,), so that only moves between regions that near to a box are looked at.
    """
    crossing = np.zeros(len(source), dtype=bool)
    low, high = regions.x_window_m.T
    for box in boxes:
        near = box.near(regions.controlled, steps)
        for block in blocks(len(source), _BLOCK):
            rows = block.start + np.flatnonzero(near[source[block]] & near[target[block]])
            i, j = source[rows], target[rows]
            below = np.maximum(high[i], high[j]) <= box.low[0] + ROUNDING
            above = np.minimum(low[i], low[j]) >= box.high[0] - ROUNDING
            across = ~(below | above)
            rows, i, j = rows[across], i[across], j[across]
            crossing[rows] |= _meets(box, regions.controlled[i, 1:], regions.controlled[j, 1:])
    return crossing


def _meets(box: Box, here: FloatArray, there: FloatArray) -> BoolArray:
    """Tell which lines from `here` to `there`, both (m, 4), pass through the inside of a box: slab by slab."""
    low, high = box.low[1:] + ROUNDING, box.high[1:] - ROUNDING
    change = there - here
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (low - here) / change, (high - here) / change
    still = change == 0.0
    between = (here > low) & (here < high)
    enter = np.where(still, np.where(between, -np.inf, np.inf), np.minimum(first, second))
    leave = np.where(still, np.where(between, np.inf, -np.inf), np.maximum(first, second))
    meets: BoolArray = np.maximum(enter.max(axis=1), 0.0) < np.minimum(leave.min(axis=1), 1.0)
    return meets
