"""Bounds of actuators, tilts and joint angles over a proven box."""

import numpy as np
from flint import arb, arb_series

from pipeline.arrays import FloatArray
from pipeline.inclusion.closure import Closure, Vector, cross, dot
from pipeline.inclusion.condition import above, below, norm
from pipeline.inclusion.following import TELESCOPE, Erring, joint_moves
from pipeline.inclusion.matrices import inner
from pipeline.inclusion.pieces import middle
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.inclusion.ranges import polynomial_range
from pipeline.machine.joints.cone import JointCone
from pipeline.machine.pose import TILT_COLUMNS


def actuator_ranges(box: ProvenBox) -> FloatArray:
    """Bound the actuators over a box from below and above, shape (5, 2)."""
    interval = box.inclusion.box
    centre, _ = middle(interval.first, interval.last)
    coefficients = ([arb(value) for value in q] for q in box.piece.taylor(centre))
    ranges = [polynomial_range(q, box.series.half) for q in coefficients]
    return np.array([(below(least), above(largest)) for least, largest in ranges])


def tilt_magnitudes(box: ProvenBox) -> FloatArray:
    """Bound |rx| and |rz| over a box from above, shape (2,)."""
    bounds = []
    for column in TILT_COLUMNS:
        cubic = [arb(value) for value in box.inclusion.box.pose[:, column].tolist()]
        least, largest = polynomial_range(cubic, box.series.half)
        bounds.append(above(largest.max(-least) + box.inclusion.image[column]))
    return np.array(bounds)


def joint_cosine(box: ProvenBox, cone: JointCone) -> tuple[float, float, float]:
    """Bound the cosine of a joint's angle over a box from below, for all errors of the actuators.

    Says, too, how far it may be from a line, and how much the errors take.

    With v from the cart joint to the platform joint and the axis e, it is e . v / len at a cart and -(R e) . v / len at
    the platform, len being |v| at the poses of the box. It is taken as c0 + c1 t + c2 t^2, with c0 and c1 about the
    middle and c2 about every t; errors a_k change it by up to |dc/da_k| A_k, and poses within d of that by no more than
    v and R e do.
    """
    half = box.series.half
    try:
        about, everywhere = (_cosine(closure, cone) for closure in (box.series.at, box.series.over))
    except ZeroDivisionError:
        return -1.0, 1.0, 1.0
    ends = [about[0] + about[1] * t for t in (-half, half)]
    bend, moved, by_errors = half * half * everywhere[2], _moved(box, cone), _by_errors(box.erring, cone)
    least = ends[0].lower().min(ends[1].lower()) + bend.lower().min(arb(0)) - moved - by_errors
    return below(least), above(bend.abs_upper() + moved), above(by_errors)


def angle_above_deg(cosine: float) -> float:
    """Bound the angle of a cosine from above, in degrees."""
    return above(arb(min(max(cosine, -1.0), 1.0)).acos() * 180 / arb.pi())


def _cosine(closure: Closure[arb_series], cone: JointCone) -> arb_series:
    vector, axis = closure.vectors[cone.link], [arb(value) for value in cone.axis.tolist()]
    if not cone.at_platform:
        along = vector[0] * axis[0] + vector[1] * axis[1] + vector[2] * axis[2]
        return along / closure.lengths[cone.link]
    turned: Vector = [row[0] * axis[0] + row[1] * axis[1] + row[2] * axis[2] for row in closure.rotation]
    return -dot(turned, vector) / closure.lengths[cone.link]


def _by_errors(errors: Erring | None, cone: JointCone) -> arb:
    """Bound sum |dc/da_k| A_k, with dv = P_xyz + T P_angles - d and d(R e) = (E P_angles) x R e."""
    if errors is None:
        return arb(0)
    hull, link, table = errors.hull, cone.link, errors.following.over.table()
    axis, joint = [arb(value) for value in cone.axis.tolist()], len(hull.arms) + cone.link
    vector, length = hull.vectors[link], hull.lengths[link]
    pointing = [-inner(row, axis) for row in hull.rotation] if cone.at_platform else axis
    total = arb(0)
    for k, (move, error) in enumerate(zip(joint_moves(errors), errors.following.errors, strict=True)):
        v = [move[c, joint] - move[c, link] for c in range(3)]
        change = inner(pointing, v)
        if cone.at_platform:
            spin = [sum((hull.axes[j][c] * table[3 + j][k] for j in range(3)), arb(0)) for c in range(3)]
            change += inner(cross(spin, pointing), vector)
        if TELESCOPE.get(link) == k:
            change -= inner(pointing, vector) / length
        total += (change / length).abs_upper() * error
    return total.abs_upper()


def _moved(box: ProvenBox, cone: JointCone) -> arb:
    """Bound how far displacements move the cosine: |dv| + |d(R e)| |v| + |v| |dlen| / len, per length."""
    off, over, errors = box.displacement, box.series.over, box.erring
    vector, length = [entry[0] for entry in over.vectors[cone.link]], over.lengths[cone.link][0]
    if errors is not None:
        vector, length = errors.hull.vectors[cone.link], errors.hull.lengths[cone.link]
    moved, size, longer = off.vectors[cone.link], norm(vector), off.lengths[cone.link]
    if cone.at_platform:
        moved += off.turn * (size + moved)
    if longer > 0:
        moved += size * longer / length.abs_lower()
    left = length.abs_lower() - longer
    return (moved / left).abs_upper() if left > 0 else arb("inf")
