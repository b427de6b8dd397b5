"""The corridor: which poses the refined path may have at each s.

The path goes through the working modes of the route in their order, for which its budget and its difference from other
routes were proven; only around the place where an arm changes may it do so back and forth. Between two neighbouring
steps of the route the corridor is also the box that holds both, widened by a number of cells; a free corridor has no
box. In both cases the tilt limit holds, a locked axis keeps its tolerance, and a box to avoid cuts off the corridor at
the side that the coarse path is farthest beyond. Start, goal, approach poses and poses to visit are exact; straight
ends keep to their cones (`cone`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.limits.avoid import Box, boxes_to_avoid
from pipeline.limits.tilt import node_limits_rad
from pipeline.machine.pose import CONTROLLED, RY, TILT_COLUMNS
from pipeline.refine.coarse import corner_parameters, move_of
from pipeline.refine.corridor.cone import NO_WALLS, Walls, narrow_to, straight_ends, walls_at
from pipeline.refine.corridor.sides import sides_at
from pipeline.refine.result import Path
from pipeline.route.metric import step_sizes
from pipeline.route.result import Route

_BULGE = 0.02
"""Grid steps that a node keeps from the wall of its cells: between two nodes the path bulges outwards."""
_SIDE_MARGIN_M = 1e-4
"""Distance that a cart keeps at the nodes from the other side of its platform joint where it must not change."""


@dataclass(frozen=True, eq=False)
class Corridor:
    """Bounds of nodes.

    Attributes
    ----------
    low, high : (k, 6)
        Bounds of the poses.
    sides : (k, 3)
        1 where the cart of an arm has to be at larger x than its platform joint (mode R), -1 where at smaller x (L),
        0 where the arm is free.
    side_margin_m : float
        Least side * (cart - platform joint) along the rail.
    walls : Walls
        Planes that the TCP stays behind.
    """

    low: FloatArray
    high: FloatArray
    sides: FloatArray
    side_margin_m: float
    walls: Walls = NO_WALLS


def corridor(config: Config, route: Route, coarse: Path, s: FloatArray) -> Corridor:
    """Bound the poses of nodes at s (k,), the first and the last of which are the start and the goal.

    Poses to visit and approach poses are those of the nodes nearest to their places on the route.
    """
    bounds = open_corridor(config, route, coarse, s)
    low, high = bounds.low, bounds.high
    _visit(config, route, s, visit_parameters(coarse, route), low, high)
    for end in straight_ends(config, route, coarse):
        node = int(np.abs(s - end.s).argmin())
        low[node] = high[node] = route.pose[end.step]
    # Poses that are given are as they are.
    bounds.sides[(low == high).all(axis=1, where=np.arange(6) != RY)] = 0.0
    return bounds


def open_corridor(config: Config, route: Route, coarse: Path, s: FloatArray) -> Corridor:
    """Bound the poses of nodes at s (k,) without poses to visit and approach poses."""
    low, high = _cells_around(config, route, coarse, s)
    for column, limit in zip(TILT_COLUMNS, node_limits_rad(config), strict=True):
        low[:, column] = np.clip(low[:, column], -limit, limit)
        high[:, column] = np.clip(high[:, column], -limit, limit)
    if boxes := boxes_to_avoid(config):
        _avoid(config, boxes, coarse.pose(s), low, high)
    low[[0, -1]] = high[[0, -1]] = route.pose[[0, -1]]
    ends = straight_ends(config, route, coarse)
    narrow_to(ends, s, low, high)
    sides = _sides_around(route, coarse, s)
    sides[[0, -1]] = 0.0
    return Corridor(low, high, sides, _SIDE_MARGIN_M, walls_at(ends, s))


def cells_excess(config: Config, route: Route, coarse: Path, s: FloatArray, pose: FloatArray) -> FloatArray:
    """Compute how far poses (n, 6) at s (n,) are outside a corridor of cells, in grid steps, negative inside. (n,)."""
    low, high = _cells(config, route, move_of(coarse, s))
    beyond = np.maximum(low - pose, pose - high)[:, CONTROLLED] / step_sizes(config.route)
    return np.asarray(beyond.max(axis=1), dtype=float)


def visit_parameters(coarse: Path, route: Route) -> FloatArray:
    """Return the parameter s of every visit, in their order, shape (visits,)."""
    steps = [int(np.argmax(route.visits == number)) for number in range(1, int(route.visits.max()) + 1)]
    return corner_parameters(coarse)[steps]


def _cells(config: Config, route: Route, move: IntArray) -> tuple[FloatArray, FloatArray]:
    """Compute the boxes around both steps of moves (n,), widened. Shapes (n, 6)."""
    here, there = route.pose[move], route.pose[move + 1]
    widening = np.full(6, np.inf)
    widening[CONTROLLED] = config.refine.corridor_cells * step_sizes(config.route)
    return np.minimum(here, there) - widening, np.maximum(here, there) + widening


def _cells_around(config: Config, route: Route, coarse: Path, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Compute boxes for nodes s (k,): what all moves from the node before to the one after share. Shapes (k, 6).

    The path between two nodes is then inside as well, wherever it passes from one box to the next.
    """
    if config.refine.corridor == "free":
        return np.full((len(s), 6), -np.inf), np.full((len(s), 6), np.inf)
    all_low, all_high = _cells(config, route, np.arange(len(route) - 1))
    move = move_of(coarse, s)
    first, last = move[np.maximum(np.arange(len(s)) - 1, 0)], move[np.minimum(np.arange(len(s)) + 1, len(s) - 1)]
    bulge = np.zeros(6)
    bulge[CONTROLLED] = min(_BULGE, config.refine.corridor_cells / 2.0) * step_sizes(config.route)
    low = np.stack([all_low[a : b + 1].max(axis=0) for a, b in zip(first, last, strict=True)]) + bulge
    high = np.stack([all_high[a : b + 1].min(axis=0) for a, b in zip(first, last, strict=True)]) - bulge
    # Where nodes are too sparse to have a common part, the box of the node's own move is used.
    none = (low > high).any(axis=1)
    low[none], high[none] = all_low[move[none]], all_high[move[none]]
    return low, high


def _sides_around(route: Route, coarse: Path, s: FloatArray) -> FloatArray:
    """Compute sides for nodes s (k,), those of neighbouring nodes included unless they contradict. Shape (k, 3)."""
    sides = sides_at(route, coarse, s)
    around = np.sign(sides + np.vstack([sides[1:], sides[-1:]]) + np.vstack([sides[:1], sides[:-1]]))
    return np.where(sides == 0.0, around, sides)


def _avoid(config: Config, boxes: Sequence[Box], pose: FloatArray, low: FloatArray, high: FloatArray) -> None:
    """Cut the corridor (k, 6) along boxes to avoid; `pose` (k, 6) are those of the coarse path."""
    steps, margin = step_sizes(config.route), np.full(5, config.refine.clearance_margin_m)
    margin[3:] = np.deg2rad(config.refine.tilt_margin_deg)
    controlled, nodes = pose[:, CONTROLLED], np.arange(len(pose))
    for box in boxes:
        beyond = np.concatenate([box.low - controlled, controlled - box.high], axis=1) / np.tile(steps, 2)
        side = beyond.argmax(axis=1)
        axis, below = CONTROLLED[side % 5], side < 5
        upper = np.where(below, (box.low - margin)[side % 5], np.inf)
        lower = np.where(below, -np.inf, (box.high + margin)[side % 5])
        high[nodes, axis] = np.minimum(high[nodes, axis], upper)
        low[nodes, axis] = np.maximum(low[nodes, axis], lower)


def _visit(config: Config, route: Route, s: FloatArray, visited: FloatArray, low: FloatArray, high: FloatArray) -> None:
    """Narrow the corridor (k, 6) to the visits of the task, at the nodes nearest to those of the route."""
    for number, (visit, at) in enumerate(zip(config.task.visit, visited, strict=True), start=1):
        node = int(np.abs(s - at).argmin())
        if visit.box is None:
            low[node] = high[node] = route.pose[route.visits == number][0]
        else:
            box = Box.of(visit.box)
            low[node, CONTROLLED] = np.maximum(low[node, CONTROLLED], box.low)
            high[node, CONTROLLED] = np.minimum(high[node, CONTROLLED], box.high)
