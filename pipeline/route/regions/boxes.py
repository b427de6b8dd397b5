"""Boxes of controlled poses: what the TCP must not enter, and what it may be asked to visit.

x is no grid axis, so a box to avoid cuts the windows of x of the regions beside it. A move between two cut
regions is clear when both are on the same side of the box along X, or when the line between them in y, z, rx, rz
passes the box by: whatever x does, no pose of the line is then inside.
"""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import BoxConfig, Config
from pipeline.route.metric import step_sizes
from pipeline.route.regions.table import RegionTable

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Box:
    """Least and largest x, y, z, rx, rz, both (5,), in metres and radians; infinite where any value will do."""

    low: FloatArray
    high: FloatArray

    @classmethod
    def of(cls, config: BoxConfig) -> "Box":
        """Read a box."""
        sides = []
        for key in ("x_m", "y_m", "z_m", "rx_deg", "rz_deg"):
            interval = getattr(config, key) or (-np.inf, np.inf)
            sides.append(np.deg2rad(interval) if key.endswith("deg") else np.array(interval))
        low, high = np.array(sides, dtype=float).T
        return cls(low, high)

    def grown(self, by: FloatArray) -> "Box":
        """The box with `by` (5,) added on every side."""
        return Box(self.low - by, self.high + by)

    def across(self) -> "Box":
        """The box with any x."""
        return Box(np.append(-np.inf, self.low[1:]), np.append(np.inf, self.high[1:]))

    def inside(self, controlled: FloatArray) -> BoolArray:
        """Tell which controlled poses (..., 5) are inside, the surface left out."""
        deep: BoolArray = (controlled > self.low + _ROUNDING) & (controlled < self.high - _ROUNDING)
        inside: BoolArray = np.asarray(deep.all(axis=-1))
        return inside

    def near(self, controlled: FloatArray, steps: FloatArray) -> BoolArray:
        """Tell which controlled poses (..., 5) are, at whatever x, within one of `steps` (5,) of it or inside."""
        return self.across().grown(steps * (1.0 + _ROUNDING)).inside(controlled)

    def depth_m(self, controlled: FloatArray) -> FloatArray:
        """Distance of controlled poses (..., 5) to the nearest side, in metres and radians; negative outside."""
        depth: FloatArray = np.minimum(controlled - self.low, self.high - controlled).min(axis=-1)
        return depth


def boxes_to_avoid(config: Config) -> list[Box]:
    """Read `task.avoid`: the boxes as they are, for poses known exactly."""
    return [Box.of(box) for box in config.task.avoid]


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
        rows = np.flatnonzero(near[source] & near[target])
        i, j = source[rows], target[rows]
        below = np.maximum(high[i], high[j]) <= box.low[0] + _ROUNDING
        above = np.minimum(low[i], low[j]) >= box.high[0] - _ROUNDING
        crossing[rows] |= ~(below | above) & _meets(box, regions.controlled[i, 1:], regions.controlled[j, 1:])
    return crossing


def _meets(box: Box, here: FloatArray, there: FloatArray) -> BoolArray:
    """Tell which lines from `here` to `there`, both (m, 4), pass through the inside of a box: slab by slab."""
    low, high = box.low[1:] + _ROUNDING, box.high[1:] - _ROUNDING
    change = there - here
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (low - here) / change, (high - here) / change
    still = change == 0.0
    between = (here > low) & (here < high)
    enter = np.where(still, np.where(between, -np.inf, np.inf), np.minimum(first, second))
    leave = np.where(still, np.where(between, np.inf, -np.inf), np.maximum(first, second))
    meets: BoolArray = np.maximum(enter.max(axis=1), 0.0) < np.minimum(leave.min(axis=1), 1.0)
    return meets
