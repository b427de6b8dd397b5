"""Distances between the axes of links, and between links and rails.

The distance of two segments is the distance of their lines where the lines' closest points lie inside both,
and otherwise the least distance of an end point to the other segment. This holds for parallel links, too.
"""

from itertools import combinations

import numpy as np

from pipeline.arguments import require_one_length, require_shape
from pipeline.arrays import FloatArray
from pipeline.machine.geometry import ARM_OF_LINK, Machine, cart_joints, cross, dot, link_vectors
from pipeline.machine.rails import rail_frame, rail_origins

_PARALLEL = 1e-12
"""sin^2 of the angle below which two links count as parallel: no common perpendicular, end points decide."""


def link_pairs(machine: Machine) -> list[tuple[int, int]]:
    """Pairs of links that share no joint, as indices into the link order."""
    return [(a, b) for a, b in combinations(range(6), 2) if not _share_joint(machine, a, b)]


def _share_joint(machine: Machine, a: int, b: int) -> bool:
    """Tell whether two links meet on a cart or the platform, as a calibrated machine says it: nearly in one point."""
    ends = [machine.platform_points_m] + ([machine.cart_offsets_m] if ARM_OF_LINK[a] == ARM_OF_LINK[b] else [])
    return any(np.linalg.norm(points[a] - points[b]) <= machine.shared_joint_m for points in ends)


def link_distances(machine: Machine, pose: FloatArray, carts_m: FloatArray) -> FloatArray:
    """Distances between the axes of all `link_pairs`, for poses (n, 6) and carts (n, 3). Shape (n, pairs).

    Raises
    ------
    ArgumentError
        If poses or carts have other shapes.
    """
    _require_rows(pose, carts_m)
    start = cart_joints(machine, carts_m)
    vector = link_vectors(machine, pose, carts_m)
    columns = [segment_distance(start[:, a], vector[:, a], start[:, b], vector[:, b]) for a, b in link_pairs(machine)]
    return np.stack(columns, axis=1)


def _require_rows(pose: FloatArray, carts_m: FloatArray) -> None:
    require_shape("pose", pose, ("n", 6))
    require_shape("carts_m", carts_m, ("n", 3))
    require_one_length(pose=pose, carts_m=carts_m)


def rail_pairs(machine: Machine) -> list[tuple[int, int]]:
    """Pairs (link, rail) with the rail of another arm."""
    return [(link, rail) for link in range(6) for rail in range(len(machine.rails_m)) if ARM_OF_LINK[link] != rail]


def link_rail_distances(machine: Machine, pose: FloatArray, carts_m: FloatArray) -> FloatArray:
    """Distances of links to the other arms' rails, taken as endless lines. Shape (n, rail pairs)."""
    start, vector = cart_joints(machine, carts_m), link_vectors(machine, pose, carts_m)
    if machine.has_parallel_rails:
        columns = [
            _point_segment(machine.rails_m[rail], start[:, link, 1:], vector[:, link, 1:])
            for link, rail in rail_pairs(machine)
        ]
    else:
        columns = []
        for link, rail in rail_pairs(machine):
            frame, origin = rail_frame(machine, rail)[1:].T, rail_origins(machine)[rail]
            columns.append(_point_segment(origin @ frame, start[:, link] @ frame, vector[:, link] @ frame))
    return np.stack(columns, axis=1)


def min_distances(machine: Machine, pose: FloatArray, carts_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least link-link and least link-rail distance at poses (n, 6) with carts (n, 3). Two arrays (n,).

    Raises
    ------
    ArgumentError
        If poses or carts have other shapes.
    """
    _require_rows(pose, carts_m)
    return (
        link_distances(machine, pose, carts_m).min(axis=1),
        link_rail_distances(machine, pose, carts_m).min(axis=1),
    )


def segment_distance(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
    """Distance between the segments p + [0, 1] u and q + [0, 1] v, all of shape (n, 3). Shape (n,)."""
    ends = np.minimum.reduce(
        [
            _point_segment(p, q, v),
            _point_segment(p + u, q, v),
            _point_segment(q, p, u),
            _point_segment(q + v, p, u),
        ]
    )
    signed, s, t = common_perpendicular(p, u, q, v)
    inside = (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    return np.where(inside, np.minimum(np.abs(signed), ends), ends)


def common_perpendicular(
    p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Signed distance of two lines along u x v, and where on them (in lengths of u and v) it is taken.

    All NaN for parallel lines, which have no unique common perpendicular. Shapes (n,).
    """
    r = p - q
    uu, vv, uv = dot(u, u), dot(v, v), dot(u, v)
    ur, vr = dot(u, r), dot(v, r)
    normal = cross(u, v)
    square = uu * vv - uv**2
    square = np.where(square > _PARALLEL * uu * vv, square, np.nan)
    s = (uv * vr - vv * ur) / square
    t = (uu * vr - uv * ur) / square
    return dot(normal, r) / np.sqrt(square), s, t


def _point_segment(point: FloatArray, start: FloatArray, vector: FloatArray) -> FloatArray:
    """Distance of points (..., k) from segments start + [0, 1] vector, k = 2 or 3. Shape (...)."""
    away = [point[..., k] - start[..., k] for k in range(vector.shape[-1])]
    along = [vector[..., k] for k in range(vector.shape[-1])]
    squared = sum(v * v for v in along)
    with np.errstate(invalid="ignore", divide="ignore"):
        fraction = np.clip(sum(a * v for a, v in zip(away, along, strict=True)) / squared, 0.0, 1.0)
    fraction = np.where(squared > 0.0, fraction, 0.0)
    distance: FloatArray = np.sqrt(sum((a - fraction * v) ** 2 for a, v in zip(away, along, strict=True)))
    return distance
