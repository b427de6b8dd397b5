"""Rigorous lower bounds of the distances between the surfaces of bodies over a whole box.

The points of their hulls are placed, as balls, along x(t) and for all errors of the actuators; distances of hulls less
both radii are those of surfaces.

Where a link is cut short, or a tube ends, by metres along its axis, its length over the box, errors included, decides
where that is at most: the hull is taken between these points.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat, arb_series

from pipeline.arrays import FloatArray
from pipeline.inclusion.bounds import actuator_ranges
from pipeline.inclusion.closure import Closure
from pipeline.inclusion.condition import above, skew
from pipeline.inclusion.distances.hulls import LOST, Directions, MovingHulls, separated, separating_directions
from pipeline.inclusion.following import Erring, joint_moves
from pipeline.inclusion.krawczyk import Piecewise
from pipeline.inclusion.matrices import upper_vector
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.machine.geometry import ACTUATORS, ARM_OF_LINK, TELESCOPES
from pipeline.machine.shapes.model import Bodies, FrameKind, SweptHull

_ORDERS = 3


@dataclass(frozen=True, eq=False)
class _Frames:
    """The frames that hulls move with, as balls: middles and radii of their coefficients of order 0, 1 and 2 in t.

    Attributes
    ----------
    tcp, rotation : (2, orders, 3), (2, orders, 3, 3)
        TCP and R.
    origins : (2, orders, 3, 3)
        The points of the rails that the carts are at.
    carts, platform : (2, orders, 6, 3)
        Cart joints and platform joints.
    """

    tcp: FloatArray
    rotation: FloatArray
    origins: FloatArray
    carts: FloatArray
    platform: FloatArray


@dataclass(frozen=True, eq=False)
class _Reach:
    """How far the machine may be off its series.

    Attributes
    ----------
    shift, turn : float
        Bounds of how far the pose is off: its place, and the sum of its angles.
    platform, carts : (6,)
        Bounds of how far platform joints and cart joints are off.
    origins, rails : (3,)
        The same of the points of the rails that carts are at, and of rails.
    lengths : (6, 2)
        Least and largest length of each link, with all errors.
    errors_m : (5,)
        Bounds of the errors of the actuators.
    """

    shift: float
    turn: float
    platform: FloatArray
    carts: FloatArray
    origins: FloatArray
    rails: FloatArray
    lengths: FloatArray
    errors_m: FloatArray


@dataclass(frozen=True, eq=False)
class _Moves:
    """How frames move with the error of each actuator, as balls: middles and radii.

    Attributes
    ----------
    tcp, turning : (2, 5, 3), (2, 5, 3, 3)
        dp/de, and dR/de.
    carts, platform : (2, 5, 6, 3)
        The same of cart joints and platform joints.
    """

    tcp: FloatArray
    turning: FloatArray
    carts: FloatArray
    platform: FloatArray


_Points = tuple[FloatArray, FloatArray, float, FloatArray, FloatArray]
"""Of one hull, what `MovingHulls` has of many."""


def body_distance_bounds(box: ProvenBox, bodies: Bodies) -> FloatArray:
    """Bound the distances of all pairs from below over a proven box, negative if nothing is known. Shape (pairs,).

    With errors of the actuators, for all of them.
    """
    series, half = box.series, above(box.series.half)
    frames = series.derive(_Frames, lambda: _frames(box))
    reach, moves = _reach(box), None if box.erring is None else _moves(box.erring)
    placed = [_points(frames, reach, moves, hull) for hull in bodies.hulls]
    bounds = np.full(len(bodies.pairs), -np.inf)
    for size, pairs in _by_size(bodies).items():
        first, second = (_gather(bodies, placed, pairs, side) for side in (0, 1))
        radii = np.array([bodies.radii_m(bodies.pairs[k]) for k in pairs])
        directions = _directions(series, (bodies, size, moves is None), first, second)
        found = separated(first, second, directions, half, reach.errors_m)
        bounds[pairs] = np.nextafter(found - radii - LOST, -np.inf)
    return bounds


def _by_size(bodies: Bodies) -> dict[tuple[int, int], list[int]]:
    """Group pairs by the numbers of points of both hulls."""
    groups: dict[tuple[int, int], list[int]] = {}
    for k, (i, j) in enumerate(bodies.pairs):
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
    series: Piecewise, key: tuple[Bodies, tuple[int, int], bool], first: MovingHulls, second: MovingHulls
) -> Directions:
    """Choose directions once for all sizes of errors: ends of links move little with these."""
    return series.derive(key, lambda: separating_directions(first, second, above(series.half)))


def _points(frames: _Frames, reach: _Reach, moves: _Moves | None, hull: SweptHull) -> _Points:
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
        moved[0, hull.number : hull.number + 1, :, 0] = 1.0
    middle[0] += given
    return middle, radius, _off(reach, hull), *moved


def _off(reach: _Reach, hull: SweptHull) -> float:
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


def _frames(box: ProvenBox) -> _Frames:
    closures = (box.series.at, box.series.at, box.series.over)
    return _Frames(
        tcp=_balls([[x[k] for x in one.pose[:3]] for k, one in enumerate(closures)]),
        rotation=_balls([[[x[k] for x in row] for row in one.rotation] for k, one in enumerate(closures)]),
        origins=_balls([_origins(box, one, k) for k, one in enumerate(closures)]),
        carts=_balls([_cart_joints(box, one, k) for k, one in enumerate(closures)]),
        platform=_balls([_platform_joints(one, k) for k, one in enumerate(closures)]),
    )


def _reach(box: ProvenBox) -> _Reach:
    errors, off = upper_vector(box.inclusion.following.errors), box.displacement
    lengths = np.repeat(np.asarray(box.machine.lengths_m)[:, None], 2, axis=1)
    lengths[TELESCOPES] = actuator_ranges(box)[3:]
    if box.inclusion.following.any:
        spread = errors[3:, None] * [-1.0, 1.0]
        lengths[TELESCOPES] = np.nextafter(lengths[TELESCOPES] + spread, [-np.inf, np.inf])
    if box.ellipsoid is not None:
        spread = np.array([above(longer) for longer in off.lengths])[:, None] * [-1.0, 1.0]
        lengths = np.nextafter(lengths + spread, [-np.inf, np.inf])
    return _Reach(
        shift=above(off.shift),
        turn=above(off.turn),
        platform=np.array([above(one) for one in off.platform]),
        carts=np.array([above(one) for one in off.carts]),
        origins=np.array([above(one) for one in off.origins]),
        rails=np.array([above(one) for one in off.rails]),
        lengths=lengths,
        errors_m=errors if box.inclusion.following.any else np.zeros(len(ACTUATORS)),
    )


def _moves(errors: Erring) -> _Moves:
    """Enclose how frames move: with the axes E of the angles, dR/de = (E P_angles) x R."""
    P, hull = errors.following.over, errors.hull
    shift, turn = (np.array(P.table(), dtype=object)[rows] for rows in (slice(0, 3), slice(3, 6)))
    spins = (arb_mat(hull.axes).transpose() * arb_mat(turn.tolist())).transpose().table()
    R, joints = arb_mat(hull.rotation), _balls([move.transpose().table() for move in joint_moves(errors)])
    links = len(hull.arms)
    return _Moves(
        tcp=_balls(shift.T.tolist()),
        turning=_balls([(skew(spin) * R).table() for spin in spins]),
        carts=joints[:, :, :links],
        platform=joints[:, :, links : 2 * links],
    )


def _origins(box: ProvenBox, closure: Closure[arb_series], order: int) -> list[list[arb]]:
    constant = arb(int(order == 0))
    return [
        [closure.q[arm][order], arb(y) * constant, arb(z) * constant]
        for arm, (y, z) in enumerate(box.machine.rails_m.tolist())
    ]


def _cart_joints(box: ProvenBox, closure: Closure[arb_series], order: int) -> list[list[arb]]:
    constant = arb(int(order == 0))
    return [
        [closure.q[ARM_OF_LINK[link]][order] + x * constant, y * constant, z * constant]
        for link, (x, y, z) in enumerate(box.balls.anchors)
    ]


def _platform_joints(closure: Closure[arb_series], order: int) -> list[list[arb]]:
    return [[p[order] + a[order] for p, a in zip(closure.pose, arm, strict=False)] for arm in closure.arms]


def _balls(table: object) -> FloatArray:
    """Turn nested lists of balls into middles and radii, stacked; radii include what the middles are rounded by."""
    entries = np.array(table, dtype=object)
    middle = np.array([float(entry.mid()) for entry in entries.ravel()])
    radius = np.array(
        [above((entry - arb(value)).abs_upper()) for entry, value in zip(entries.ravel(), middle.tolist(), strict=True)]
    )
    return np.stack([middle.reshape(entries.shape), radius.reshape(entries.shape)])
