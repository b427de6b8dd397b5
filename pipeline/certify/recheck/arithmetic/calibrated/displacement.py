"""How far parts of a machine may be off, over many boxes: the statement of `pipeline.inclusion.displacement`."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.calibrated.closures import (
    along_x,
    first_order,
    link_changes,
    operator_norms,
    row_norms,
    second_order,
    turned_points,
)
from pipeline.certify.recheck.arithmetic.enclosure import (
    Enclosure,
    bound,
    constant,
    contract,
    cross,
    exactly,
    spread,
    times,
    total,
    within,
)
from pipeline.certify.recheck.arithmetic.motion import Motion, follow
from pipeline.certify.recheck.arithmetic.norms import arm_lengths, joint_shift, norm
from pipeline.inclusion.calibrated.ellipsoid import Ellipsoid
from pipeline.machine.geometry import Machine

if TYPE_CHECKING:
    from pipeline.certify.recheck.arithmetic.inclusion import Boxes, Inclusions


@dataclass(frozen=True, eq=False)
class Displacement:
    """Bounds over each box, boxes last.

    Of the pose (6, n); of TCP and orientation, `shift` and `turn` (n,); of `platform` and `carts` joints, `arms`,
    `vectors` and `lengths`, all (6, n); of `origins` of carts and of `rails`, (3, n); and of `actuators` (5, n).
    `moves` (15, 3, m, n) is what u / k does to cart joints, platform joints and rails, and `rest` (15, n) bounds what
    else moves them.
    """

    pose: FloatArray
    shift: FloatArray
    turn: FloatArray
    platform: FloatArray
    carts: FloatArray
    arms: FloatArray
    vectors: FloatArray
    lengths: FloatArray
    origins: FloatArray
    rails: FloatArray
    actuators: FloatArray
    rest: FloatArray
    moves: Enclosure | None = None


def of_pose(machine: Machine, deviation: FloatArray) -> Displacement:
    """Bound displacements of the configured machine whose pose is off by up to (6, n)."""
    turn = total(*deviation[3:])
    platform, none = joint_shift(machine, deviation), np.zeros_like(deviation)
    return Displacement(
        pose=deviation,
        shift=norm(deviation[:3]),
        turn=turn,
        platform=platform,
        carts=none,
        arms=times(arm_lengths(machine)[:, None], turn),
        vectors=platform,
        lengths=none,
        origins=none[:3],
        rails=none[:3],
        actuators=none[:5],
        rest=np.concatenate([none, platform, none[:3]]),
    )


def of_machines(machine: Machine, boxes: "Boxes", found: "Inclusions", ellipsoid: Ellipsoid) -> Displacement:
    """Bound displacements of all machines of an ellipsoid."""
    k, h = np.array(ellipsoid.sigma), boxes.half
    changes = link_changes(ellipsoid, boxes.over.q[0])
    C = exactly(found.inverse[0]) + exactly(found.inverse[1]) * within(h)
    moved = -contract("iln,lmn->imn", C, first_order(boxes.over, changes), 6)
    second = second_order(boxes.over, changes, ellipsoid.sigma)
    rest = total(bound("iln,ln->in", C.magnitude, second, terms=6), found.image)
    pose = total(times(row_norms(moved), k), rest)
    hull, own = _hull(machine, boxes, pose), of_pose(machine, rest)
    axes, arms = hull.axes[0], hull.arms[0]
    across = cross(spread(axes, 0), spread(arms, 1), axis=2)
    turned = contract("ljcn,jmn->lcmn", across, moved[3:], 3) + turned_points(hull.rotation[0], changes)
    shift = spread(moved[:3], 0)
    platform = turned + shift
    rails = Enclosure(changes.rails.mid[..., None], changes.rails.rad[..., None])
    return Displacement(
        pose=pose,
        shift=total(times(operator_norms(shift), k)[0], own.shift),
        turn=total(*pose[3:]),
        platform=total(times(operator_norms(platform), k), own.platform),
        carts=times(operator_norms(changes.joints), k),
        arms=total(times(operator_norms(turned), k), own.arms),
        vectors=total(times(operator_norms(platform - changes.joints), k), own.vectors),
        lengths=times(row_norms(changes.lengths), k),
        origins=times(operator_norms(rails + along_x(changes.actuators[:3])), k),
        rails=times(operator_norms(rails), k) + np.zeros_like(h),
        actuators=times(row_norms(changes.actuators), k),
        rest=own.rest,
        moves=_joined([changes.joints, platform, rails]) * exactly(k),
    )


def _joined(parts: list[Enclosure]) -> Enclosure:
    """Put parts (k, 3, m, n) together; those that are the same for all boxes have n = 1."""
    n = max(part.mid.shape[-1] for part in parts)
    each = [(np.broadcast_to(values, (*values.shape[:-1], n)) for values in (part.mid, part.rad)) for part in parts]
    mid, rad = zip(*each, strict=True)
    return Enclosure(np.concatenate(mid), np.concatenate(rad))


def _hull(machine: Machine, boxes: "Boxes", reach: FloatArray) -> Motion:
    """Evaluate the closures of the configured machine over all poses of each box."""
    pose, q = boxes.over.pose, boxes.over.q
    return follow(machine, constant(pose, total(pose.rad[0], reach)), constant(q, q.rad[0]))
