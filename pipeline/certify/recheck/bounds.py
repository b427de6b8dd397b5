"""What is claimed of the machine as configured, for all boxes at once: kappa, distances, ranges, both ends."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.determinant import det_signs
from pipeline.certify.recheck.enclosure import Enclosure, bound, contract, cross, dot, exactly, root, total, within
from pipeline.certify.recheck.inclusion import Boxes, Inclusions, linear_inverse, power, residual_of_inverse
from pipeline.certify.recheck.jets import moved
from pipeline.certify.recheck.motion import Motion
from pipeline.inclusion.distances import Pairs, build_pairs, separating_directions
from pipeline.machine.geometry import ARM_OF_LINK, MODE_SIGNS, PRIMARY, TRIANGLE, Machine
from pipeline.route.regions.endpoints import Endpoint

_PARTS = 16


def kappa_bounds(machine: Machine, boxes: Boxes, deviation: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Upper bounds of kappa and the sign of det H, each (n,), for poses within `deviation` (6, n) of the cubics."""
    at, over = boxes.at.statics(), boxes.over.statics()
    H = [at[0], at[1], over[2]]
    Y = linear_inverse(H)
    h = boxes.half
    off = _statics_change(machine, boxes, deviation)
    bound_Y = _largest(exactly(Y[0]), exactly(Y[1]), h)
    bound_H = total(_largest(H[0], H[1], h), power(h, 2) * _frobenius(H[2].magnitude), off)
    squares = residual_of_inverse([exactly(part) for part in Y], H, h)
    miss = total(_frobenius(squares), bound_Y * off)
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = np.where(miss < 1.0, total(bound_H * bound_Y / (1.0 - miss)), np.inf)
    # ||I - Y0 H'|| < 1: the determinants of Y0 and H have one sign.
    return kappa, np.where(miss < 1.0, det_signs(Y[0]), 0.0)


def distance_bounds(machine: Machine, boxes: Boxes, deviation: FloatArray) -> tuple[Pairs, FloatArray]:
    """Lower bounds of the distances of all pairs, (pairs, n)."""
    pairs, h = build_pairs(machine), boxes.half
    points = [_end_points(machine, motion, order) for motion, order in ((boxes.at, 0), (boxes.at, 1), (boxes.over, 2))]
    ends = [points[0].mid + t * points[1].mid + t * t * points[2].mid for t in (-h, h)]
    before, after = (separating_directions(pairs, np.moveaxis(end, -1, 0)) for end in ends)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(h[:, None, None] > 0.0, (after - before) / (2.0 * h[:, None, None]), 0.0)
    n = [exactly(np.moveaxis(part, 0, -1)) for part in ((before + after) / 2.0, slope)]
    size = np.maximum(*(_norm(np.moveaxis((n[0] + n[1] * exactly(t)).magnitude, 1, 0)) for t in (-h, h)))
    joint = total(_norm(deviation[:3])[None], _arms(machine)[:, None] * total(*deviation[3:]))
    off = np.concatenate([np.zeros_like(joint), joint, np.zeros((3, len(h)))])
    least = np.full((len(pairs.first), len(h)), np.inf)
    for p in pairs.first.T:
        for q in pairs.second.T:
            gap = [x[p] - x[q] for x in points]
            series = [
                dot(n[0], gap[0], 1),
                dot(n[0], gap[1], 1) + dot(n[1], gap[0], 1),
                dot(n[0], gap[2], 1) + dot(n[1], gap[1], 1),
                dot(n[1], gap[2], 1),
            ]
            spread = total(*(term.magnitude * power(h, k) for k, term in enumerate(series[1:], start=1)))
            least = np.minimum(least, (series[0] - exactly(spread)).lower)
    moved_by = total(off[pairs.first].sum(axis=1), off[pairs.second].sum(axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.where(size > 0.0, least / size * (1.0 - 1e-15) - moved_by * (1.0 + 1e-15), 0.0)
    return pairs, np.maximum(np.nextafter(distance, -np.inf), 0.0)


def actuator_ranges(boxes: Boxes) -> FloatArray:
    """Bounds below and above of the actuators, (5, 2)."""
    least, largest = _ranges(boxes.q, boxes.half)
    return np.column_stack([least.min(axis=1), largest.max(axis=1)])


def tilt_bounds(boxes: Boxes, deviation: FloatArray) -> FloatArray:
    """Upper bounds of |rx| and |rz|, (2,)."""
    least, largest = _ranges(exactly(boxes.pose[:, [3, 5]]), boxes.half)
    tilt: FloatArray = total(np.maximum(-least, largest), deviation[[3, 5]]).max(axis=1)
    return tilt


def end_misses(
    machine: Machine, joints: Boxes, met: Inclusions, ends: tuple[Endpoint, Endpoint]
) -> tuple[list[float], list[bool]]:
    """How far both ends are from the task's poses at most, and whether working mode and branch are theirs."""
    misses, assembled = [], []
    for end, k in zip(ends, (0, -1), strict=True):
        away = exactly(joints.pose[0][:, k]) - exactly(end.pose)
        misses.append(float(total(away.magnitude, met.image[:, k]).max()))
        assembled.append(_is_assembly(machine, joints, met.image[:, k], end, k))
    return misses, assembled


def _is_assembly(machine: Machine, joints: Boxes, deviation: FloatArray, end: Endpoint, k: int) -> bool:
    motion, turn = joints.at, total(*deviation[3:])
    shift = total(_arms(machine) * turn, _norm(deviation[:3]))
    vectors = motion.vectors[0][..., k]
    x = Enclosure(vectors.mid[PRIMARY, 0], vectors.rad[PRIMARY, 0] + shift[PRIMARY])
    modes = bool(((x * exactly(-MODE_SIGNS[end.mode])).lower > -1e-6).all())
    first = int(PRIMARY[ARM_OF_LINK[TRIANGLE]])
    arms = motion.arms[0][..., k]
    side = arms[TRIANGLE] - arms[first]
    base = machine.cart_offsets_m[TRIANGLE] - machine.cart_offsets_m[first]
    leg = vectors[first] - Enclosure(base, np.abs(base) * 1e-15)
    side, leg = (Enclosure(part.mid, part.rad + 2.0 * shift.max() + 1e-15) for part in (side, leg))
    axis = motion.axes[0][1, :, k]
    axis = Enclosure(axis.mid, axis.rad + 2.0 * turn)
    triangle = dot(axis, cross(side, leg, 0), 0) * exactly(machine.triangle_sign)
    return modes and bool(triangle.lower > 0.0)


def _largest(M0: Enclosure, M1: Enclosure, h: FloatArray) -> FloatArray:
    """Bound ||M0 + M1 t||_2 for |t| <= h, (n,): convex in t, so at the ends, by nearly orthogonal singular vectors."""
    bounds = []
    for t in (-h, h):
        end = M0 + M1 * exactly(t)
        V = np.linalg.svd(np.moveaxis(end.mid, -1, 0))[2].transpose(2, 1, 0)
        turned = contract("ijn,jkn->ikn", exactly(end.mid), exactly(V), 6)
        square = contract("jin,jkn->ikn", turned, turned, 6).magnitude
        loss = (contract("jin,jkn->ikn", exactly(V), exactly(V), 6) - exactly(np.eye(6)[..., None])).magnitude
        largest = total(*square.swapaxes(0, 1)).max(axis=0) / (1.0 - total(*loss.swapaxes(0, 1)).max(axis=0))
        bounds.append(total(root(total(largest)), _frobenius(end.rad)))
    return np.maximum(*bounds)


def _statics_change(machine: Machine, boxes: Boxes, deviation: FloatArray) -> FloatArray:
    """Bound what H changes by with the pose, in the Frobenius norm, (n,)."""
    arm, turn = _arms(machine)[:, None], total(*deviation[3:])
    by_vector = total(np.broadcast_to(_norm(deviation[:3]), (6, len(turn))), arm * turn)
    size = _norm(np.moveaxis(boxes.over.vectors[0].magnitude, 1, 0))
    by_moment = total(arm * by_vector, arm * turn * size, arm * turn * by_vector)
    length = boxes.over.lengths[0].lower
    return root(total(*(total(by_vector**2, by_moment**2) / length**2)))


def _end_points(machine: Machine, motion: Motion, order: int) -> Enclosure:
    """Cart joints, platform joints and rails, (15, 3, n): terms of one order."""
    tcp, arms, vectors = motion.pose[order][:3], motion.arms[order], motion.vectors[order]
    platform = Enclosure(tcp.mid[None], tcp.rad[None]) + arms
    carts = platform - vectors
    rails = np.zeros((3, 3, tcp.mid.shape[-1]))
    if order == 0:
        rails[:, 1:] = machine.rails_m[..., None]
    mid = np.concatenate([carts.mid, platform.mid, rails])
    return Enclosure(mid, np.concatenate([carts.rad, platform.rad, np.zeros_like(rails)]))


def _ranges(coefficients: Enclosure, half: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bounds below and above of polynomials (orders, k, n) over each interval, (k, n)."""
    part, orders = half / _PARTS, len(coefficients.mid)
    lows, highs = [], []
    for k in range(_PARTS):
        about = moved(coefficients, exactly((2.0 * k + 1.0) * part - half), orders)
        spread = moved(about, within(part + 1e-12 * half), 1)[0]
        lows.append(spread.lower)
        highs.append(spread.upper)
    return np.min(lows, axis=0), np.max(highs, axis=0)


def _arms(machine: Machine) -> FloatArray:
    return root(total(*(machine.platform_points_m.T**2)))


def _norm(bounds: FloatArray) -> FloatArray:
    """Euclidean norm over the first axis."""
    return root(total(*(bounds**2)))


def _frobenius(bounds: FloatArray) -> FloatArray:
    """Frobenius norm of matrices (6, 6, n)."""
    return root(bound("ijn,ijn->n", bounds, bounds, terms=36))
