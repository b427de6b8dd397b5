"""The inclusions of all boxes at a time, evaluated again; the statement is that of `pipeline.inclusion.krawczyk`."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.certify.recheck.arithmetic.calibrated import closures
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, bound, contract, exactly, times, total, within
from pipeline.certify.recheck.arithmetic.following import (
    Following,
    follow_actuators,
    following_change,
    following_terms,
)
from pipeline.certify.recheck.arithmetic.jets import TERMS, expand
from pipeline.certify.recheck.arithmetic.motion import Motion, follow, second_derivatives
from pipeline.certify.recheck.arithmetic.norms import arm_lengths, norm
from pipeline.certify.recheck.arithmetic.splines import on_one_piece, spline_taylor
from pipeline.inclusion.krawczyk import Box
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes as arrays, boxes last, and the closures along their cubics.

    Attributes
    ----------
    first, last, centre, half : (n,)
        Intervals of s.
    on_one_piece : (n,)
        Whether no knot of the splines lies within; otherwise q is not what the actuators do.
    pose : (4, 6, n)
        Taylor coefficients about the centres.
    radius : (6, n)
        Radii.
    q : (degree + 1, 5, n)
        Taylor coefficients of the actuators about the centres.
    at, over : Motion
        Series about the centres, and series that hold about every t of the interval.
    """

    first: FloatArray
    last: FloatArray
    centre: FloatArray
    half: FloatArray
    on_one_piece: BoolArray
    pose: FloatArray
    radius: FloatArray
    q: Enclosure
    at: Motion
    over: Motion


@dataclass(frozen=True, eq=False)
class Inclusions:
    """Results: whether each box is proven (n,), its inverse (2, 6, 6, n), and k, E, D as in the statement.

    `preconditioned` bounds |C dJ| in place of |C| D (6, 6, n) for the machines of an ellipsoid. `following` has P and A
    where actuators are off.
    """

    proven: BoolArray
    inverse: FloatArray
    image: FloatArray
    residual_change: FloatArray
    jacobian_change: FloatArray
    following: Following | None = None
    preconditioned: FloatArray | None = None


def build_boxes(machine: Machine, path: Path, boxes: tuple[Box, ...]) -> Boxes:
    """Stack boxes and evaluate the closures along them."""
    first, last = (np.array([getattr(box, name) for box in boxes]) for name in ("first", "last"))
    centre = (first + last) / 2.0
    half = np.where(last > first, np.nextafter(np.maximum(last - centre, centre - first), np.inf), 0.0)
    pose, radius = np.stack([box.pose for box in boxes], -1), np.stack([box.radius for box in boxes], -1)
    q = spline_taylor(path.spline.t, path.spline.c, path.spline.k, first, centre)
    at, over = (
        follow(machine, expand(exactly(pose), where), expand(q, where))
        for where in (exactly(np.zeros_like(half)), within(half))
    )
    return Boxes(first, last, centre, half, on_one_piece(path.spline, first, last), pose, radius, q, at, over)


def include(
    machine: Machine, boxes: Boxes, uncertainty: Uncertainty, actuators_m: FloatArray | None = None
) -> Inclusions:
    """Verify the inclusion of every box with its own radii.

    With errors `actuators_m` (5, n) of the actuators over each, in place of the uncertainty's.
    """
    if actuators_m is None:
        actuators_m = np.repeat(np.array(uncertainty.actuator_m)[:, None], len(boxes.first), axis=1)
    h, r = boxes.half, boxes.radius
    at, over = boxes.at.jacobian(), boxes.over.jacobian()
    J = [at[0], at[1], over[2]]
    inverse = linear_inverse(J)
    C = [exactly(part) for part in inverse]
    C_over = C[0] + C[1] * within(h)
    C_abs = C_over.magnitude
    miss = residual_of_inverse(C, J, h)
    off = actuators_m.max(axis=0)
    E = _residual_change(boxes.over, uncertainty, off)
    calibrated = bound("ijn,jn->in", C_abs, E, terms=6)
    following = None
    if actuators_m.any():
        following = follow_actuators((boxes.at, boxes.over), inverse, J, h, actuators_m)
    moved_by = calibrated if following is None else total(calibrated, following.moved)
    hull = _hull(machine, boxes, total(moved_by, r))
    D, CD = _jacobian_change(machine, hull, uncertainty, off), None
    if uncertainty.ellipsoid is not None:
        CD = closures.preconditioned_change(hull, C_over, uncertainty.ellipsoid)
    G = contract("iln,lkjn->ikjn", C_over, second_derivatives(hull), 6)
    GC = contract("ikjn,jmn->ikmn", G, C_over, 6)
    spread = total(
        bound("ikjn,jn->ikn", G.magnitude, r, terms=6), bound("ikmn,mn->ikn", GC.magnitude, E, terms=6), miss
    )
    bent = contract("kan,ikmn->iamn", C_over, GC, 6).magnitude
    parts = [
        _residual(C, boxes),
        bound("ijn,jn->in", miss, calibrated, terms=6),
        0.5 * bound("ian,an->in", bound("iabn,bn->ian", bent, E, terms=6), E, terms=6),
        _turned(C_abs, (D, CD), total(moved_by, r)),
    ]
    if following is not None:
        terms = following_terms(following, hull, C_over, G)
        spread = total(spread, terms.spread)
        parts += [terms.image, bound("iln,ln->in", terms.mixed, E, terms=6)]
    image = total(*parts, bound("ikn,kn->in", spread, r, terms=6))
    return Inclusions(np.all(image < r, axis=0) & boxes.on_one_piece, inverse, image, E, D, following, CD)


def _turned(C: FloatArray, change: tuple[FloatArray, FloatArray | None], moved: FloatArray) -> FloatArray:
    """Bound |C| D moved, (6, n), or with a bound of |C dJ|, if there is one, in place of both."""
    D, preconditioned = change
    if preconditioned is not None:
        return bound("ikn,kn->in", preconditioned, moved, terms=6)
    return bound("iln,ln->in", C, bound("lkn,kn->ln", D, moved, terms=6), terms=6)


def linear_inverse(J: list[Enclosure]) -> FloatArray:
    """Compute C0 and C1 in floats, shape (2, 6, 6, n)."""
    J0, J1 = (np.moveaxis(part.mid, -1, 0) for part in J[:2])
    C0 = np.linalg.inv(J0)
    return np.moveaxis(np.stack([C0, -C0 @ J1 @ C0]), 1, -1)


def residual_of_inverse(C: list[Enclosure], J: list[Enclosure], h: FloatArray) -> FloatArray:
    """Bound |I - C(t) J(t)| over each interval, shape (6, 6, n)."""

    def product(a: Enclosure, b: Enclosure) -> Enclosure:
        return contract("ijn,jkn->ikn", a, b, 6)

    identity = exactly(np.eye(6)[..., None])
    terms = [
        identity - product(C[0], J[0]),
        product(C[0], J[1]) + product(C[1], J[0]),
        product(C[0], J[2]) + product(C[1], J[1]),
        product(C[1], J[2]),
    ]
    return total(*(bound("ijn,n->ijn", term.magnitude, power(h, n), terms=1) for n, term in enumerate(terms)))


def power(h: FloatArray, n: int) -> FloatArray:
    """Compute h^n, rounded up."""
    result = np.ones_like(h)
    for _ in range(n):
        result = total(result * h)
    return result


def holds(boxes: Boxes, found: Inclusions, joints: Boxes, met: Inclusions, at_end: bool) -> BoolArray:
    """Return whether each of n boxes holds the joint at its end, or at its beginning, of n + 1 joints. Shape (n,)."""
    of = slice(1, None) if at_end else slice(None, -1)
    s = exactly(joints.first[of]) - exactly(boxes.centre)
    x = expand(exactly(boxes.pose), s)[0]
    apart = (x - exactly(joints.pose[0][:, of])).magnitude
    C = exactly(found.inverse[0]) + exactly(found.inverse[1]) * s
    turned = (C - exactly(met.inverse[0][..., of])).magnitude
    parts = [
        apart,
        met.image[:, of],
        bound("ijn,jn->in", turned, met.residual_change[:, of], terms=6),
        _turned(C.magnitude, (found.jacobian_change, found.preconditioned), apart),
    ]
    if found.following is not None and met.following is not None:
        parts.append(
            following_change(found.following, s, met.following.matrix[0][..., of], met.following.errors[:, of])
        )
    reach = total(*parts)
    return np.asarray(np.all(reach < boxes.radius, axis=0), dtype=bool)


def _residual(C: list[Enclosure], boxes: Boxes) -> FloatArray:
    """Bound |C(t) f(x(t), t)|, shape (6, n)."""
    at, over = boxes.at.residuals(), boxes.over.residuals()
    parts = []
    for n in range(TERMS):
        f = over[n] if n + 1 == TERMS else at[n]
        for k, part in enumerate(C):
            product = contract("ijn,jn->in", part, f, 6)
            parts.append(bound("in,n->in", product.magnitude, power(boxes.half, n + k), terms=1))
    return total(*parts)


def _hull(machine: Machine, boxes: Boxes, reach: FloatArray) -> Motion:
    """Evaluate the closures over all poses of each box: constant terms only."""
    pose = Enclosure(np.zeros_like(boxes.over.pose.mid), np.zeros_like(boxes.over.pose.rad))
    pose.mid[0], pose.rad[0] = boxes.over.pose.mid[0], total(boxes.over.pose.rad[0], reach)
    q = Enclosure(boxes.over.q.mid.copy(), boxes.over.q.rad.copy())
    q.mid[1:], q.rad[1:] = 0.0, 0.0
    return follow(machine, pose, q)


def _residual_change(over: Motion, uncertainty: Uncertainty, off: FloatArray) -> FloatArray:
    """Bound E, shape (6, n), where actuators are off by up to (n,)."""
    eps, eta = np.array(uncertainty.length_m), np.array(uncertainty.coordinate_m)
    lengths = over.lengths[0].magnitude
    if not uncertainty.calibration:
        return np.zeros_like(lengths)
    if uncertainty.ellipsoid is not None:
        return closures.residual_change(over, uncertainty.ellipsoid)
    lengths = total(lengths, off[None])
    v = over.vectors[0]
    v = Enclosure(v.mid, v.rad.copy())
    v.rad[:] = total(v.rad, times(np.abs(over.rails)[..., None], off))
    local = contract("ijn,lin->ljn", over.rotation[0], v, 3).magnitude
    sizes = v.magnitude
    seen = total(local[:, 0], local[:, 1], local[:, 2], sizes[:, 0], 2.0 * sizes[:, 1], 2.0 * sizes[:, 2])
    offset = np.full_like(lengths, _offset(eta))
    return total(times(eps, lengths), times(np.full_like(lengths, eps), eps), times(eta, seen), times(offset, offset))


def _jacobian_change(machine: Machine, hull: Motion, uncertainty: Uncertainty, off: FloatArray) -> FloatArray:
    """Bound D, shape (6, 6, n), where actuators are off by up to (n,)."""
    v = hull.vectors[0].magnitude
    D = np.zeros((6, 6, v.shape[-1]))
    eta = np.array(uncertainty.coordinate_m)
    if eta > 0.0:
        size, arm = norm(np.moveaxis(v, 1, 0)), arm_lengths(machine)[:, None]
        size = total(size, times(norm(np.abs(hull.rails).T)[:, None], off))
        w = _offset(eta)
        D[:, :3] = times(np.array(3.8), eta)
        D[:, 3:] = total(times(arm, w), times(np.array(1.8), eta, total(size, np.full_like(size, w))))[:, None]
    return D


def _offset(eta: FloatArray) -> FloatArray:
    """Bound of |w|: sqrt(3) eta and sqrt(1 + 4 + 4) eta, the first rounded up to 1.8."""
    return times(np.array(4.8), eta)
