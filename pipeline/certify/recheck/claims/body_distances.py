"""The least distances between the surfaces of bodies, and of bodies and obstacles, if there are any."""

from collections.abc import Iterator, Sequence

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds, Ranges
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, contract, dot, exactly, rounded_down, times, total
from pipeline.certify.recheck.arithmetic.inclusion import Boxes, power
from pipeline.certify.recheck.arithmetic.motion import Motion
from pipeline.certify.recheck.arithmetic.norms import joint_shift, norm
from pipeline.certify.recheck.arithmetic.ranges import polynomial_ranges
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence, lower_bounds
from pipeline.config import Config
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, Machine
from pipeline.machine.shapes.gjk import hull_separation
from pipeline.machine.shapes.model import Bodies, FrameKind, SweptHull
from pipeline.machine.shapes.obstacles import build_obstacles

BODIES = "bodies keep their required distances"
OBSTACLES = "bodies keep their required distances from obstacles"
CLAIMS: tuple[str, ...] = (BODIES, OBSTACLES)
KEYS: tuple[str, ...] = ("body_distance_m", "obstacle_distance_m")


def measure(config: Config, machine: Machine, segment: EvaluatedChain) -> FloatArray:
    """Bound the distances of all pairs over some boxes; none without bodies and obstacles."""
    bounds = [
        body_distance_bounds(machine, bodies, segment.boxes, segment.inclusions.image).min(axis=1)
        for bodies in _groups(config, machine).values()
    ]
    return lower_bounds(np.concatenate([np.empty(0), *bounds]))


def _groups(config: Config, machine: Machine) -> dict[str, Bodies]:
    """List the pairs of bodies, and of bodies and obstacles, by the keys of their bounds."""
    found = dict(zip(KEYS, (machine.bodies, build_obstacles(config.machine, config.task.obstacles)), strict=True))
    return {key: bodies for key, bodies in found.items() if bodies is not None}


def check(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify the distances of all pairs for every s; none may be stated of what there is not."""
    groups, begin = _groups(evidence.config, evidence.machine), 0
    for key, what in zip(KEYS, CLAIMS, strict=True):
        bodies = groups.get(key)
        if bodies is None:
            yield Claim(what, verified=key not in stated.ranges, found="there are none")
            continue
        least = evidence.least[begin : begin + len(bodies.pairs)]
        begin += len(bodies.pairs)
        yield _verdict(what, bodies, least, stated.ranges.get(key))


def _verdict(what: str, bodies: Bodies, least: FloatArray, ranges: Ranges | None) -> Claim:
    if ranges is None or ranges.subjects != bodies.names:
        return Claim(what, verified=False, found="not stated" if ranges is None else "other pairs are stated")
    proven, required = ranges.values[:, 0], bodies.clearance_m
    kept = (least >= proven) & (proven >= required)
    shown = int(np.argmin(least) if kept.all() else np.argmin(kept))
    found = f"{bodies.names[shown]} {least[shown]:.6g} m, stated {proven[shown]:.6g}, required {required:g}"
    return Claim(what, bool(kept.all()), found)


def body_distance_bounds(machine: Machine, bodies: Bodies, boxes: Boxes, deviation: FloatArray) -> FloatArray:
    """Bound the distances of all pairs from below, for poses within `deviation` (6, n) of the cubics. Shape (pairs, n).

    The statement is that of `pipeline.inclusion.distances.bodies`.
    """
    motions = ((boxes.at, 0), (boxes.at, 1), (boxes.over, 2))
    lengths = _length_ranges(machine, boxes)
    hulls = [[_points(machine, hull, motion, order, lengths) for motion, order in motions] for hull in bodies.hulls]
    shifts = [_shift(machine, hull, lengths, deviation) for hull in bodies.hulls]
    bounds = []
    for i, j in bodies.pairs:
        first, second = hulls[i], hulls[j]
        if bodies.is_endless((i, j)):
            first, second = ([_across(points) for points in hull] for hull in (first, second))
        apart = _separated(first, second, boxes.half)
        lost = total(shifts[i], shifts[j], np.array(bodies.hulls[i].radius_m), np.array(bodies.hulls[j].radius_m))
        bounds.append(np.nextafter(apart - lost, -np.inf))
    return np.array(bounds).reshape(len(bodies.pairs), len(boxes.half))


def _separated(first: Sequence[Enclosure], second: Sequence[Enclosure], h: FloatArray) -> FloatArray:
    """Bound the distances of two hulls, by a direction linear in t and by a constant one. Shape (n,)."""
    before, after = (hull_separation(_middles(first, t), _middles(second, t)).normal for t in (-h, h))
    mean = (before + after) / 2.0
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(h > 0.0, (after - before) / (2.0 * h), 0.0)
    return np.maximum(*(_along(first, second, (exactly(mean), exactly(turn)), h) for turn in (slope, 0.0 * slope)))


def _middles(points: Sequence[Enclosure], t: FloatArray) -> FloatArray:
    """Evaluate the middles of points at t (n,), shape (k, 3, n)."""
    return np.asarray(points[0].mid + t * points[1].mid + t * t * points[2].mid, dtype=float)


def _along(
    first: Sequence[Enclosure], second: Sequence[Enclosure], n: tuple[Enclosure, Enclosure], h: FloatArray
) -> FloatArray:
    """Bound min n . (a - b) / |n| for |t| <= h, n = n0 + n1 t; -1 if that is not positive. Shape (n,)."""
    a, b = (_heights(points, n) for points in (first, second))
    gap = [one[:, None] - other[None] for one, other in zip(a, b, strict=True)]
    spread = total(*(times(term.magnitude, power(h, k)) for k, term in enumerate(gap[1:], start=1)))
    least = (gap[0] - exactly(spread)).lower.min(axis=(0, 1))
    size = np.maximum(*(norm((n[0] + n[1] * exactly(t)).magnitude) for t in (-h, h)))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((least > 0.0) & (size > 0.0), rounded_down(least / size, 1), -1.0)


def _heights(points: Sequence[Enclosure], n: tuple[Enclosure, Enclosure]) -> list[Enclosure]:
    """Compute the coefficients of n . a of order 0 to 3 in t, shape (k, n) each."""
    one, two = (_each(part) for part in n)
    return [
        dot(one, points[0], 1),
        dot(one, points[1], 1) + dot(two, points[0], 1),
        dot(one, points[2], 1) + dot(two, points[1], 1),
        dot(two, points[2], 1),
    ]


def _across(points: Enclosure) -> Enclosure:
    """Leave out x of points (k, 3, n)."""
    keep = np.array([0.0, 1.0, 1.0])[None, :, None]
    return Enclosure(points.mid * keep, points.rad * keep)


def _points(machine: Machine, hull: SweptHull, motion: Motion, order: int, lengths: FloatArray) -> Enclosure:
    """Return the coefficients of one order of the points of a hull, shape (k, 3, n)."""
    n = motion.pose.mid.shape[-1]
    tcp = motion.pose[order][:3]
    given = hull.points_m
    if hull.kind == FrameKind.PLATFORM:
        turned = contract("ijn,kj->kin", motion.rotation[order], exactly(given), 3)
        return Enclosure(tcp.mid[None], tcp.rad[None]) + turned
    if hull.kind == FrameKind.LINK:
        link = hull.number
        arm = int(ARM_OF_LINK[link])
        constant = exactly(machine.cart_offsets_m[link]) + exactly(np.append(0.0, machine.rails_m[arm]))
        cart = _moving_along_x(motion, arm, order, constant, n)
        platform = tcp + motion.arms[order][link]
        parts = exactly(_parts(hull, lengths[link])[:, None])
        rest = exactly(np.ones_like(parts.mid)) - parts
        return rest * _each(cart) + parts * _each(platform)
    constant = exactly(given)
    if hull.kind == FrameKind.FIXED:
        mid = np.zeros((*given.shape, n))
        mid += given[..., None] if order == 0 else 0.0
        return exactly(mid)
    constant = constant + exactly(np.append(0.0, machine.rails_m[hull.number]))
    return _moving_along_x(motion, hull.number, order, constant, n)


def _moving_along_x(motion: Motion, arm: int, order: int, constant: Enclosure, n: int) -> Enclosure:
    """Place points (..., 3), given from x of a cart, at the cart: coefficients of one order, shape (..., 3, n)."""
    shape = (*constant.mid.shape, n)
    mid, rad = np.zeros(shape), np.zeros(shape)
    cart = motion.q[order][arm]
    mid[..., 0, :], rad[..., 0, :] = cart.mid, cart.rad
    moving = Enclosure(mid, rad)
    if order:
        return moving
    return moving + Enclosure(constant.mid[..., None], constant.rad[..., None])


def _each(values: Enclosure) -> Enclosure:
    """Repeat values along a first axis."""
    return Enclosure(values.mid[None], values.rad[None])


def _length_ranges(machine: Machine, boxes: Boxes) -> FloatArray:
    """Bound the lengths of the links over the boxes from below and above, shape (6, 2, n)."""
    lengths = np.repeat(np.nan_to_num(machine.lengths_m)[:, None, None], 2, axis=1) + np.zeros(len(boxes.half))
    least, largest = polynomial_ranges(boxes.q, boxes.half)
    lengths[TELESCOPES, 0], lengths[TELESCOPES, 1] = least[3:], largest[3:]
    return lengths


def _parts(hull: SweptHull, lengths: FloatArray) -> FloatArray:
    """Bound both ends of a hull on a link as parts of its length (2, n), as far apart as possible. Shape (2, n)."""
    (f, s), (g, t) = hull.points_m.tolist()
    first = f + s / lengths
    last = g + t / lengths
    # Two roundings each.
    low, high = first.min(axis=0), last.max(axis=0)
    return np.stack([low - 1e-15 if s else low, high + 1e-15 if t else high])


def _shift(machine: Machine, hull: SweptHull, lengths: FloatArray, deviation: FloatArray) -> FloatArray:
    """Bound how far a point of a hull is off, for poses within `deviation` (6, n) of the cubics. Shape (n,)."""
    if hull.kind == FrameKind.LINK:
        part = np.maximum(_parts(hull, lengths[hull.number])[1], 0.0)
        return times(joint_shift(machine, deviation)[hull.number], part)
    if hull.kind != FrameKind.PLATFORM:
        return np.zeros(deviation.shape[1])
    far = norm(hull.points_m.T).max()
    turn = total(*deviation[3:])
    return total(norm(deviation[:3]), times(np.full_like(turn, far), turn))
