"""The corridor: which poses the refined path may have at each s.

At s between two neighbouring steps of the route it is the box that holds both, widened by a number of cells,
within the tilt limit; a locked axis keeps to its tolerance. Start, goal and poses to visit are exact. A box to avoid
cuts the corridor at the one of its sides that the coarse path is farthest beyond.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.config import Config
from pipeline.machine.geometry import FloatArray
from pipeline.refine.coarse import corner_parameters, move_of
from pipeline.refine.result import Path
from pipeline.route.boxes import Box, boxes_to_avoid
from pipeline.route.metric import CONTROLLED, step_sizes
from pipeline.route.result import Route

_RY = 4
_LOCK_SHARE = 0.8
"""Share of a locked axis' tolerance allowed at the nodes; the rest is for what happens between them."""


@dataclass(frozen=True, eq=False)
class Corridor:
    """Bounds of the pose at nodes: `low`, `high` (k, 6) for x, y, z, rx, ry, rz."""

    low: FloatArray
    high: FloatArray


def corridor(config: Config, route: Route, coarse: Path, s: FloatArray, tilt_margin_rad: float) -> Corridor:
    """Bound the poses at s (k,), the first and the last of which are the start and the goal."""
    move = move_of(coarse, s)
    here, there = route.pose[move], route.pose[move + 1]
    widening = np.zeros(6)
    widening[CONTROLLED] = config.refine.corridor_cells * step_sizes(config.route)
    low = np.minimum(here, there) - widening
    high = np.maximum(here, there) + widening
    low[:, _RY], high[:, _RY] = -np.inf, np.inf
    for column, axis in ((3, "rx"), (5, "rz")):
        limit = _tilt_limit(config, axis, tilt_margin_rad)
        low[:, column] = np.clip(low[:, column], -limit, limit)
        high[:, column] = np.clip(high[:, column], -limit, limit)
    _avoid(config, coarse.pose(s), low, high)
    low[[0, -1]] = high[[0, -1]] = route.pose[[0, -1]]
    _visit(config, route, s, visit_parameters(coarse, route), low, high)
    return Corridor(low, high)


def visit_parameters(coarse: Path, route: Route) -> FloatArray:
    """Parameter s of every visit, in their order, shape (visits,)."""
    steps = [int(np.argmax(route.visits == number)) for number in range(1, int(route.visits.max()) + 1)]
    visited: FloatArray = corner_parameters(coarse)[steps]
    return visited


def _avoid(config: Config, pose: FloatArray, low: FloatArray, high: FloatArray) -> None:
    """Cut the corridor (k, 6) along boxes to avoid; `pose` (k, 6) is that of the coarse path."""
    steps, margin = step_sizes(config.route), np.full(5, config.refine.clearance_margin_m)
    margin[3:] = np.deg2rad(config.refine.tilt_margin_deg)
    controlled, nodes = pose[:, CONTROLLED], np.arange(len(pose))
    for box in boxes_to_avoid(config):
        beyond = np.concatenate([box.low - controlled, controlled - box.high], axis=1) / np.tile(steps, 2)
        side = beyond.argmax(axis=1)
        axis, below = CONTROLLED[side % 5], side < 5
        upper = np.where(below, (box.low - margin)[side % 5], np.inf)
        lower = np.where(below, -np.inf, (box.high + margin)[side % 5])
        high[nodes, axis] = np.minimum(high[nodes, axis], upper)
        low[nodes, axis] = np.maximum(low[nodes, axis], lower)


def _visit(config: Config, route: Route, s: FloatArray, visited: FloatArray, low: FloatArray, high: FloatArray) -> None:
    """Narrow the corridor (k, 6) to what is to be visited, at the nodes nearest to the route's visits."""
    for number, (visit, at) in enumerate(zip(config.task.visit, visited, strict=True), start=1):
        node = int(np.abs(s - at).argmin())
        if visit.box is None:
            low[node] = high[node] = route.pose[route.visits == number][0]
        else:
            box = Box.of(visit.box)
            low[node, CONTROLLED] = np.maximum(low[node, CONTROLLED], box.low)
            high[node, CONTROLLED] = np.minimum(high[node, CONTROLLED], box.high)


def _tilt_limit(config: Config, axis: str, margin_rad: float) -> float:
    if axis in config.task.locked_axes:
        return _LOCK_SHARE * float(np.deg2rad(config.refine.lock_tolerance_deg))
    return max(float(np.deg2rad(config.task.tilt_max_deg)) - margin_rad, 0.0)
