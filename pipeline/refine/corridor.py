"""The corridor: which poses the refined path may have at each s.

At s between two neighbouring steps of the route it is the box that holds both, widened by a number of cells,
within the tilt limit; a locked axis keeps to its tolerance. Start and goal are exact.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.config import Config
from pipeline.machine.geometry import FloatArray
from pipeline.refine.coarse import move_of
from pipeline.refine.result import Path
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
    low[[0, -1]] = high[[0, -1]] = route.pose[[0, -1]]
    return Corridor(low, high)


def _tilt_limit(config: Config, axis: str, margin_rad: float) -> float:
    if axis in config.task.locked_axes:
        return _LOCK_SHARE * float(np.deg2rad(config.refine.lock_tolerance_deg))
    return max(float(np.deg2rad(config.task.tilt_max_deg)) - margin_rad, 0.0)
