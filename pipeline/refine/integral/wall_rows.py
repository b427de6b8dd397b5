"""The rows of straight ends: the TCP at a node stays behind walls."""

import casadi as ca
import numpy as np

from pipeline.limits.interface.rows import Row
from pipeline.refine.corridor.cone import Walls


def wall_rows(walls: Walls, pose: ca.MX) -> list[Row]:
    """Write normal . (x, y, z) - offset <= 0 for poses (6, k) of nodes."""
    if len(walls) == 0:
        return []
    distance = ca.sum1(ca.DM(walls.normal.T) * pose[:3, walls.node.tolist()]).T - ca.DM(walls.offset)
    return [Row("cones of straight ends", distance, -np.inf, 0.0)]
