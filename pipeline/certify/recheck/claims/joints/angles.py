"""The angles of joints that have a cone."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.calibrated.displacement import Displacement
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.enclosure import (
    Enclosure,
    bound,
    contract,
    cross,
    dot,
    exactly,
    rounded_down,
    times,
    total,
)
from pipeline.certify.recheck.arithmetic.erring import Erring
from pipeline.certify.recheck.arithmetic.following import EXTENSIBLE
from pipeline.certify.recheck.arithmetic.inclusion import Boxes, power
from pipeline.certify.recheck.arithmetic.jets import TERMS, sine_cosine
from pipeline.certify.recheck.arithmetic.motion import Motion
from pipeline.certify.recheck.arithmetic.norms import norm
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence, upper_bounds
from pipeline.config import Config
from pipeline.machine.geometry import Machine
from pipeline.machine.joints.cone import JointCone

ANGLES = "joints stay within their cones"
CLAIMS: tuple[str, ...] = (ANGLES,)
KEYS: tuple[str, ...] = ("joint_angle_deg",)

_ORDERS = 3
_ROUNDING = 1e-12
"""What a cosine is taken less by, so that the one computed from its angle again is not more."""


def measure(config: Config, machine: Machine, segment: EvaluatedChain) -> FloatArray:
    """Bound the angles of all joints with a cone over some boxes, in degrees; none where none has one."""
    if not machine.joint_cones:
        return np.empty((0, 2))
    off = segment.displacement(machine), segment.erring(machine)
    return upper_bounds(angles_above_deg(joint_cosines(machine, segment.boxes, *off).min(axis=1)))


def check(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify the angle of every joint that has a cone for every s."""
    cones, ranges = evidence.machine.joint_cones, stated.ranges.get(KEYS[0])
    if not cones:
        yield Claim(ANGLES, verified=ranges is None, found="no joint has a cone")
        return
    names = tuple(cone.joint for cone in cones)
    if ranges is None or ranges.subjects != names:
        missing = [name for name in names if ranges is None or name not in ranges.subjects]
        yield Claim(ANGLES, verified=False, found=f"other joints are stated; missing: {', '.join(missing) or 'none'}")
        return
    found, proven = evidence.largest, ranges.values[:, 1]
    allowed = np.array([cone.half_angle_deg for cone in cones])
    kept = (found <= proven) & (proven <= allowed)
    shown = int(np.argmin(allowed - found) if kept.all() else np.argmin(kept))
    degrees = f"{found[shown]:.6g}, stated {proven[shown]:.6g}, allowed {allowed[shown]:g} degrees"
    yield Claim(ANGLES, bool(kept.all()), f"{names[shown]} {degrees}")


def joint_cosines(machine: Machine, boxes: Boxes, off: Displacement, errors: Erring | None = None) -> FloatArray:
    """Bound the cosines of all joints with a cone from below, for joints displaced from those along the cubics.

    With errors of the actuators, for all of them: the joints are then displaced from those along the cubics and P a.

    The statement is that of `pipeline.inclusion.bounds.joint_cosine`. Shape (cones, n).
    """
    h = boxes.half
    along = [(motion, motion.statics()) for motion in (boxes.at, boxes.over)]
    found, hull = [], boxes.over if errors is None else errors.hull
    for cone in machine.joint_cones:
        about, everywhere = (_terms(cone, *motion) for motion in along)
        ends = [(about[0] + about[1] * exactly(t)).lower for t in (-h, h)]
        moved, size = off.vectors[cone.link], norm(hull.vectors[0].magnitude[cone.link])
        if cone.at_platform:
            moved = total(moved, times(off.turn, total(size, moved)))
        length = hull.lengths[0].lower[cone.link]
        left = rounded_down(length - off.lengths[cone.link], 1)
        with np.errstate(divide="ignore", invalid="ignore"):
            moved = total(moved, times(size, total(off.lengths[cone.link] / length)))
            by_pose = np.where((left > 0.0) & (length > 0.0), total(moved / left), np.inf)
        # Cosines that bend upward are least at an end.
        rest = total(times(power(h, 2), np.maximum(-everywhere[2].lower, 0.0)), by_pose)
        if errors is not None:
            rest = total(rest, bound("an,an->n", _rates(cone, errors).magnitude, errors.errors, terms=5))
        found.append((exactly(np.minimum(*ends)) - exactly(rest)).lower)
    return np.array(found)


def _rates(cone: JointCone, errors: Erring) -> Enclosure:
    """Enclose the derivatives of the cosine by the error of each actuator, shape (5, n)."""
    hull, link = errors.hull, cone.link
    pointing = exactly(np.repeat(cone.axis[:, None], errors.errors.shape[-1], axis=1))
    if cone.at_platform:
        pointing = -contract("ijn,j->in", hull.rotation[0], exactly(cone.axis), 3)
    vector, inverse = hull.vectors[0][link], hull.lengths[0][link].inverse()
    change = contract("cn,can->an", pointing, errors.moved[link], 3)
    if cone.at_platform:
        turned = cross(errors.spin, Enclosure(pointing.mid[:, None], pointing.rad[:, None]), axis=0)
        change = change + contract("can,cn->an", turned, vector, 3)
    longer = exactly(EXTENSIBLE[link][:, None]) * (dot(pointing, vector, 0) * inverse)
    return (change - longer) * inverse


def _terms(cone: JointCone, motion: Motion, statics: Enclosure) -> list[Enclosure]:
    """Compute the cosine's coefficients of order 0 to 2, shape (n,) each."""
    u, axis = [statics[order][cone.link, :3] for order in range(_ORDERS)], exactly(cone.axis)
    if not cone.at_platform:
        return [contract("in,i->n", part, axis, 3) for part in u]
    turned = [contract("ijn,j->in", motion.rotation[order], axis, 3) for order in range(_ORDERS)]
    found = []
    for order in range(_ORDERS):
        parts = [dot(turned[k], u[order - k], 0) for k in range(order + 1)]
        found.append(-sum(parts[1:], parts[0]))
    return found


def angles_above_deg(cosines: FloatArray) -> FloatArray:
    """Bound the angles of cosines (m,) from above, in degrees: 180 where nothing less can be shown."""
    angles = np.arccos(np.clip(cosines - _ROUNDING, -1.0, 1.0))
    series = np.zeros((TERMS, len(angles)))
    series[0] = angles
    _, cosine = sine_cosine(exactly(series))
    known = np.where(cosine[0].upper <= cosines, angles, np.pi)
    # The float nearest to pi is below it: this factor is above the exact one.
    return times(known, total(np.array(180.0 / np.pi)))
