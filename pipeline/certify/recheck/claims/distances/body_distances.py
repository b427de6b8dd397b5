"""The least distances between the surfaces of bodies, and of bodies and obstacles, if there are any."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds, Ranges
from pipeline.certify.recheck.arithmetic.calibrated.displacement import Displacement
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, contract, cross, exactly, times, total
from pipeline.certify.recheck.arithmetic.erring import Erring, joint_moves
from pipeline.certify.recheck.arithmetic.inclusion import Boxes
from pipeline.certify.recheck.arithmetic.motion import Motion, on_rails
from pipeline.certify.recheck.arithmetic.norms import norm
from pipeline.certify.recheck.arithmetic.ranges import polynomial_ranges
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.distances.hulls import MovingHull, separated
from pipeline.certify.recheck.claims.evidence import Evidence, lower_bounds
from pipeline.config import Config
from pipeline.machine.geometry import ACTUATORS, ARM_OF_LINK, TELESCOPES, Machine
from pipeline.machine.shapes.model import Bodies, FrameKind, SweptHull
from pipeline.machine.shapes.obstacles import build_obstacles

BODIES = "bodies keep their required distances"
OBSTACLES = "bodies keep their required distances from obstacles"
CLAIMS: tuple[str, ...] = (BODIES, OBSTACLES)
KEYS: tuple[str, ...] = ("body_distance_m", "obstacle_distance_m")


def measure(config: Config, machine: Machine, segment: EvaluatedChain) -> FloatArray:
    """Bound the distances of all pairs over some boxes; none without bodies and obstacles."""
    groups = _groups(config, machine)
    if not groups:
        return np.empty((0, 2))
    off = segment.displacement(machine), segment.erring(machine)
    bounds = [body_distance_bounds(machine, bodies, segment.boxes, off).min(axis=1) for bodies in groups.values()]
    return lower_bounds(np.concatenate(bounds))


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


def required_m(config: Config, machine: Machine) -> FloatArray:
    """Return the required distance of every pair that `measure` bounds."""
    groups = _groups(config, machine).values()
    return np.concatenate([np.empty(0), *(np.full(len(bodies.pairs), bodies.clearance_m) for bodies in groups)])


def body_distance_bounds(
    machine: Machine, bodies: Bodies, boxes: Boxes, off: tuple[Displacement, Erring | None]
) -> FloatArray:
    """Bound the distances of all pairs from below, for joints displaced from those along the cubics. (pairs, n).

    With errors of the actuators, for all of them: the joints are then displaced from those along the cubics and P a.
    The statement is that of `pipeline.inclusion.distances.bodies`.
    """
    motions, (displacement, errors) = ((boxes.at, 0), (boxes.at, 1), (boxes.over, 2)), off
    errors_m = np.zeros((len(ACTUATORS), len(boxes.half))) if errors is None else errors.errors
    lengths = _length_ranges(machine, boxes, errors_m)
    lengths[:, 0] = (exactly(lengths[:, 0]) - exactly(displacement.lengths)).lower
    lengths[:, 1] = (exactly(lengths[:, 1]) + exactly(displacement.lengths)).upper
    joints = None if errors is None else joint_moves(errors)
    hulls = [
        MovingHull(
            [_points(machine, hull, motion, order, lengths) for motion, order in motions],
            None if errors is None or joints is None else _moves(hull, errors, joints, lengths),
        )
        for hull in bodies.hulls
    ]
    shifts = [_shift(hull, lengths, displacement) for hull in bodies.hulls]
    bounds = []
    for i, j in bodies.pairs:
        first, second = hulls[i], hulls[j]
        if bodies.is_endless((i, j)):
            first, second = first.across_x(), second.across_x()
        apart = separated(first, second, boxes.half, errors_m)
        lost = total(shifts[i], shifts[j], np.array(bodies.hulls[i].radius_m), np.array(bodies.hulls[j].radius_m))
        bounds.append(np.nextafter(apart - lost, -np.inf))
    return np.array(bounds).reshape(len(bodies.pairs), len(boxes.half))


def _moves(hull: SweptHull, errors: Erring, joints: Enclosure, lengths: FloatArray) -> Enclosure:
    """Enclose how the points of a hull move with each error, (k, 3, 5, n), as joints (15, 3, 5, n) do."""
    if hull.kind == FrameKind.PLATFORM:
        arms = contract("ijn,kj->kin", errors.hull.rotation[0], exactly(hull.points_m), 3)
        spin = _each(errors.spin)
        turned = cross(spin, Enclosure(arms.mid[:, :, None], arms.rad[:, :, None]), axis=1)
        return turned + _each(errors.shift)
    if hull.kind == FrameKind.LINK:
        cart, platform = (_each(joints[end]) for end in (hull.number, len(ARM_OF_LINK) + hull.number))
        parts = exactly(_parts(hull, lengths[hull.number])[:, None, None])
        return (exactly(np.ones_like(parts.mid)) - parts) * cart + parts * platform
    moves = np.zeros((len(hull.points_m), *joints.mid.shape[1:]))
    if hull.kind == FrameKind.CART:
        moves[:, :, hull.number] = errors.hull.rails[hull.number == ARM_OF_LINK][0][:, None]
    return exactly(moves)


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
        cart = _moving_with_cart(machine, motion, arm, order, constant)
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
    return _moving_with_cart(machine, motion, hull.number, order, constant)


def _moving_with_cart(machine: Machine, motion: Motion, arm: int, order: int, constant: Enclosure) -> Enclosure:
    """Place points (..., 3), given for a cart at q = 0, at the cart: coefficients of one order, shape (..., 3, n)."""
    moved = on_rails(motion.q[order][arm][None], machine.rail_directions[arm][None])
    shape = (*constant.mid.shape, moved.mid.shape[-1])
    moving = Enclosure(*(np.broadcast_to(part[0], shape) for part in (moved.mid, moved.rad)))
    if order:
        return moving
    return moving + Enclosure(constant.mid[..., None], constant.rad[..., None])


def _each(values: Enclosure) -> Enclosure:
    """Repeat values along a first axis."""
    return Enclosure(values.mid[None], values.rad[None])


def _length_ranges(machine: Machine, boxes: Boxes, errors_m: FloatArray) -> FloatArray:
    """Bound the lengths of the links over the boxes from below and above, shape (6, 2, n), for errors up to (5, n)."""
    lengths = np.repeat(np.nan_to_num(machine.lengths_m)[:, None, None], 2, axis=1) + np.zeros(len(boxes.half))
    least, largest = polynomial_ranges(boxes.q, boxes.half)
    lengths[TELESCOPES, 0] = (exactly(least[3:]) - exactly(errors_m[3:])).lower
    lengths[TELESCOPES, 1] = (exactly(largest[3:]) + exactly(errors_m[3:])).upper
    return lengths


def _parts(hull: SweptHull, lengths: FloatArray) -> FloatArray:
    """Bound both ends of a hull on a link as parts of its length (2, n), as far apart as possible. Shape (2, n)."""
    (f, s), (g, t) = hull.points_m.tolist()
    first = f + s / lengths
    last = g + t / lengths
    # Two roundings each.
    low, high = first.min(axis=0), last.max(axis=0)
    return np.stack([low - 1e-15 if s else low, high + 1e-15 if t else high])


def _shift(hull: SweptHull, lengths: FloatArray, off: Displacement) -> FloatArray:
    """Bound how far a point of a hull is off where joints are displaced. Shape (n,)."""
    if hull.kind == FrameKind.LINK:
        part, cart, platform = _parts(hull, lengths[hull.number]), off.carts[hull.number], off.platform[hull.number]
        ends = total(times(total(np.abs(1.0 - part)), cart[None]), times(np.abs(part), platform[None]))
        return np.asarray(ends.max(axis=0), dtype=float)
    if hull.kind == FrameKind.PLATFORM:
        far = norm(hull.points_m.T).max()
        return total(off.shift, times(np.full_like(off.turn, far), off.turn))
    if hull.kind == FrameKind.CART:
        return np.asarray(off.origins[hull.number], dtype=float)
    return np.asarray(off.rails[hull.number - 1] if hull.number else np.zeros_like(off.turn), dtype=float)
