"""Rigorous lower bounds of the distances between the surfaces of bodies over a whole box.

The points of their hulls are placed, as balls, along x(t) and for all errors of the actuators; distances of hulls less
both radii are those of surfaces.

Where a link is cut short, or a tube ends, by metres along its axis, its length over the box, errors included, decides
where that is at most: the hull is taken between these points.
"""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.inclusion.condition import above
from pipeline.inclusion.distances.frames import Frames, Moves, Reach, frames_along, moves_by_errors, reach_of
from pipeline.inclusion.distances.hulls import LOST, Directions, MovingHulls, separated, separating_directions
from pipeline.inclusion.krawczyk import Piecewise
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.machine.geometry import ACTUATORS
from pipeline.machine.shapes.model import Bodies, FrameKind, SweptHull

_ORDERS = 3


_Points = tuple[FloatArray, FloatArray, float, FloatArray, FloatArray]
"""Of one hull, what `MovingHulls` has of many."""


def body_distance_bounds(box: ProvenBox, bodies: Bodies, enough_m: float = np.inf) -> FloatArray:
    """Bound the distances of all pairs from below over a proven box, negative if nothing is known. Shape (pairs,).

    With errors of the actuators, for all of them. Where boxes along the axes show that a pair is `enough_m` apart, its
    bound is no sharper.
    """
    series, half = box.series, above(box.series.half)
    frames = series.derive(Frames, lambda: frames_along(box))
    reach, moves = reach_of(box), None if box.erring is None else moves_by_errors(box.erring)
    placed = [_points(frames, reach, moves, hull) for hull in bodies.hulls]
    bounds = np.full(len(bodies.pairs), -np.inf)
    if np.isfinite(enough_m):
        apart = _apart_along_axes(bodies, placed, half, reach.errors_m)
        bounds = np.where(apart >= enough_m, apart, bounds)
    for pairs in _by_size(bodies, np.flatnonzero(np.isneginf(bounds)).tolist()).values():
        first, second = (_gather(bodies, placed, pairs, side) for side in (0, 1))
        radii = np.array([bodies.radii_m(bodies.pairs[k]) for k in pairs])
        directions = _directions(series, (bodies, tuple(pairs), moves is None), first, second)
        found = separated(first, second, directions, half, reach.errors_m)
        bounds[pairs] = np.nextafter(found - radii - LOST, -np.inf)
    return bounds


def _apart_along_axes(bodies: Bodies, placed: list[_Points], half: float, errors_m: FloatArray) -> FloatArray:
    """Bound the distances of all pairs from below by boxes along the axes around everything they reach, (pairs,)."""
    low, high = np.empty((2, len(placed), 3))
    for k, (hull, (middle, radius, off, moved, moved_radius)) in enumerate(zip(bodies.hulls, placed, strict=True)):
        spread = radius[0] + sum(half**n * (np.abs(middle[n]) + radius[n]) for n in range(1, _ORDERS))
        errors = errors_m[: len(moved), None, None] * (np.abs(moved) + moved_radius)
        far = spread + errors.sum(axis=0) + off + hull.radius_m
        far = far + LOST * (1.0 + np.abs(middle[0]) + far)
        low[k], high[k] = (middle[0] - far).min(axis=0), (middle[0] + far).max(axis=0)
        if hull.endless:
            low[k, 0], high[k, 0] = -np.inf, np.inf
    first, second = np.array(bodies.pairs).T
    apart = np.maximum(low[first] - high[second], low[second] - high[first]).max(axis=1)
    return np.asarray(np.nextafter(apart - LOST, -np.inf), dtype=float)


def _by_size(bodies: Bodies, chosen: list[int]) -> dict[tuple[int, int], list[int]]:
    """Group some of the pairs by the numbers of points of both hulls."""
    groups: dict[tuple[int, int], list[int]] = {}
    for k in chosen:
        i, j = bodies.pairs[k]
        groups.setdefault((len(bodies.hulls[i].points_m), len(bodies.hulls[j].points_m)), []).append(k)
    return groups


def _gather(bodies: Bodies, placed: list[_Points], pairs: list[int], side: int) -> MovingHulls:
    """Put the hulls on one side of pairs together; of pairs with one that is endless along X, x is left out."""
    chosen = [placed[bodies.pairs[k][side]] for k in pairs]
    parts = [np.stack([hull[which] for hull in chosen], axis=1) for which in (0, 1, 3, 4)]
    endless = np.array([bodies.is_endless(bodies.pairs[k]) for k in pairs])
    for part in parts:
        part[:, endless, :, 0] = 0.0
    return MovingHulls(parts[0], parts[1], np.array([hull[2] for hull in chosen]), parts[2], parts[3])


def _directions(
    series: Piecewise, key: tuple[Bodies, tuple[int, ...], bool], first: MovingHulls, second: MovingHulls
) -> Directions:
    """Choose directions once for all sizes of errors: ends of links move little with these."""
    return series.derive(key, lambda: separating_directions(first, second, above(series.half)))


def _points(frames: Frames, reach: Reach, moves: Moves | None, hull: SweptHull) -> _Points:
    """Give the coefficients of a hull's points, how far points may be off, and how they move with errors."""
    given = hull.points_m
    if hull.kind == FrameKind.PLATFORM:
        middle, radius = _on_platform(frames.tcp, frames.rotation, given)
        moved = _still(given) if moves is None else _on_platform(moves.tcp, moves.turning, given)
        far = float(np.linalg.norm(given, axis=1).max())
        return middle, radius, reach.shift + far * reach.turn, *moved
    if hull.kind == FrameKind.LINK:
        part = _parts(hull, reach.lengths[hull.number])
        middle, radius = _on_link(frames.carts, frames.platform, hull.number, part)
        moved = _still(given) if moves is None else _on_link(moves.carts, moves.platform, hull.number, part)
        ends = np.abs(1.0 - part) * reach.carts[hull.number] + np.abs(part) * reach.platform[hull.number]
        return middle, radius, float(ends.max()), *moved
    middle, radius = np.zeros((2, _ORDERS, *given.shape))
    moved = np.zeros((2, 0 if moves is None else len(ACTUATORS), *given.shape))
    if hull.kind == FrameKind.CART:
        middle += frames.origins[0][:, hull.number, None]
        radius += frames.origins[1][:, hull.number, None]
        moved[0, hull.number : hull.number + 1] = frames.rails[hull.number]
    middle[0] += given
    return middle, radius, _off(reach, hull), *moved


def _off(reach: Reach, hull: SweptHull) -> float:
    """Bound how far a hull on a cart, or one that is fixed, on a rail perhaps, may be off."""
    if hull.kind == FrameKind.CART:
        return float(reach.origins[hull.number])
    return float(reach.rails[hull.number - 1]) if hull.number else 0.0


def _still(given: FloatArray) -> FloatArray:
    return np.zeros((2, 0, len(given), 3))


def _on_platform(place: FloatArray, turned: FloatArray, given: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Place points given from the TCP: middles and radii, (n, k, 3) each."""
    middle = place[0][:, None] + np.einsum("oij,kj->oki", turned[0], given)
    radius = place[1][:, None] + np.einsum("oij,kj->oki", turned[1], np.abs(given))
    return middle, radius


def _on_link(carts: FloatArray, platform: FloatArray, link: int, parts: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Place points given as parts of a link's length (k,): middles and radii, (n, k, 3) each."""
    part = parts[None, :, None]
    ends = [(1.0 - part, carts), (part, platform)]
    middle = sum((share * joint[0][:, link, None] for share, joint in ends), np.zeros(1))
    radius = sum((np.abs(share) * joint[1][:, link, None] for share, joint in ends), np.zeros(1))
    return middle, radius


def _parts(hull: SweptHull, lengths: FloatArray) -> FloatArray:
    """Give both ends of a hull on a link as parts of its length, as far apart as any length in a range makes them."""
    parts = hull.points_m[:, 0] + hull.points_m[:, 1] / lengths[:, None]
    return np.array([parts[:, 0].min(), parts[:, 1].max()])
