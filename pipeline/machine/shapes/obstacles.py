"""What is fixed in space, and the pairs of it and everything that moves: their distances depend on x."""

from collections.abc import Sequence

import numpy as np

from pipeline.config import MachineConfig, ObstacleConfig
from pipeline.machine.shapes.hulls import body_hull, config_name, link_hulls, obstacle_hull
from pipeline.machine.shapes.model import Bodies, FrameKind, Neighbours, SweptHull

TCP = "TCP"
"""Name of the one point of a platform without bodies that is kept apart."""


def build_obstacles(config: MachineConfig, obstacles: Sequence[ObstacleConfig]) -> Bodies | None:
    """Build the pairs of everything that moves and what is fixed in space: frame and task; None if nothing is.

    Of a platform without bodies the TCP is kept apart.
    """
    bodies = [body_hull(config, body) for body in config.bodies]
    fixed = [hull for hull in bodies if hull.is_obstacle] + [obstacle_hull(obstacle) for obstacle in obstacles]
    if not fixed:
        return None
    moving = [*(hull for hull in bodies if hull.kind != FrameKind.FIXED), *link_hulls(config)]
    if not any(hull.kind == FrameKind.PLATFORM for hull in moving):
        moving.append(SweptHull(TCP, FrameKind.PLATFORM, 0, np.zeros((1, 3)), 0.0))
    ignored = {frozenset(pair) for pair in config.clearance.ignore}
    pairs, names, neighbours = [], [], []
    for i, hull in enumerate(moving):
        for j, obstacle in enumerate(fixed):
            name = f"{hull.name} and {obstacle.name}"
            if frozenset((config_name(hull), obstacle.name)) in ignored:
                neighbours.append(Neighbours(name, "machine.clearance.ignore", "not checked"))
            else:
                pairs.append((i, len(moving) + j))
                names.append(name)
    if not pairs:
        return None
    return Bodies((*moving, *fixed), tuple(pairs), tuple(names), config.clearance.bodies_m, tuple(neighbours))
