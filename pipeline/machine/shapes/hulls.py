"""The bodies of a configuration as hulls in their frames."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import BodyConfig, MachineConfig, ObstacleConfig
from pipeline.config.choices import BodyFrame
from pipeline.config.machine.bodies import LINK_NAMES, TelescopeBodyConfig
from pipeline.machine.shapes.model import FrameKind, SweptHull

_CARTS = (BodyFrame.CART1, BodyFrame.CART2, BodyFrame.CART3)
_RAILS = (BodyFrame.RAIL1, BodyFrame.RAIL2, BodyFrame.RAIL3)


def body_hull(config: MachineConfig, body: BodyConfig) -> SweptHull:
    """Turn a body into a hull in the frame it is attached to."""
    points, radius = _shape(body)
    frame, endless = body.attached_to, body.beam is not None
    if body.beam is not None:
        points, radius = np.array([(0.0, *corner) for corner in body.beam.points_m]), body.beam.radius_m
    if frame == BodyFrame.PLATFORM:
        return SweptHull(body.name, FrameKind.PLATFORM, 0, points, radius)
    if (end := frame.link_end) is not None:
        along = np.column_stack([np.full(2, end[1]), np.sort(points[[0, -1], 2])])
        return SweptHull(body.name, FrameKind.LINK, LINK_NAMES.index(end[0]), along, radius, attached=True)
    if frame in _CARTS:
        return SweptHull(body.name, FrameKind.CART, _CARTS.index(frame), points, radius)
    number = _RAILS.index(frame) + 1 if frame in _RAILS else 0
    if number:
        rail = config.rails[number - 1]
        points = points + np.array([0.0, rail.y_m, rail.z_m])
    return SweptHull(body.name, FrameKind.FIXED, number, points, radius, endless=endless)


def obstacle_hull(obstacle: ObstacleConfig) -> SweptHull:
    """Turn an obstacle of the task into a hull."""
    return SweptHull(obstacle.name, FrameKind.FIXED, 0, *_shape(obstacle))


def link_hulls(config: MachineConfig) -> Iterator[SweptHull]:
    """Give the links as rods and tubes, or as axes where they have no bodies."""
    whole = np.array([[0.0, 0.0], [1.0, 0.0]])
    for number, key in enumerate(LINK_NAMES):
        name, body = key[1:], None if config.link_bodies is None else getattr(config.link_bodies, key)
        if isinstance(body, TelescopeBodyConfig):
            yield SweptHull(f"rod {name}", FrameKind.LINK, number, whole, body.rod_radius_m)
            tube = np.array([[0.0, 0.0], [0.0, body.tube_length_m]])
            yield SweptHull(f"tube {name}", FrameKind.LINK, number, tube, body.tube_radius_m)
        else:
            yield SweptHull(f"link {name}", FrameKind.LINK, number, whole, 0.0 if body is None else body.radius_m)


def config_name(hull: SweptHull) -> str:
    """Return the name by which a body is given in the configuration."""
    return LINK_NAMES[hull.number] if hull.is_link else hull.name


def _shape(body: BodyConfig | ObstacleConfig) -> tuple[FloatArray, float]:
    """Return the points (k, 3) and the radius of a capsule, hull, mesh or box; nothing of a beam."""
    if body.capsule is not None:
        ends = dict.fromkeys([body.capsule.from_m, body.capsule.to_m])
        return np.array(list(ends)), body.capsule.radius_m
    if body.hull is not None:
        return np.array(body.hull.points_m), body.hull.radius_m
    if body.mesh is not None:
        return np.array(body.mesh.points_m), body.mesh.radius_m
    if body.box is not None:
        half = np.array(body.box.size_m) / 2.0 - body.box.rounding_m
        corners = [np.array(body.box.centre_m) + half * sides for sides in product((-1.0, 1.0), repeat=3)]
        return np.unique(corners, axis=0), body.box.rounding_m
    return np.empty((0, 3)), 0.0
