"""How statics and joints change as actuators are off, over many boxes; what is bounded is that of `pipeline.inclusion`.

With P over each interval, and everything over the hull of all proven poses and all errors, arms change by W P_angles,
W the axes crossed with the arm, link vectors by that and P_xyz, less d for the link's own cart.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, constant, contract, cross, exactly, spread, total
from pipeline.certify.recheck.arithmetic.following import EXTENSIBLE, OF_CART
from pipeline.certify.recheck.arithmetic.inclusion import Boxes, Inclusions
from pipeline.certify.recheck.arithmetic.motion import Motion, follow
from pipeline.machine.geometry import Machine


@dataclass(frozen=True, eq=False)
class Erring:
    """Boxes whose actuators are off: A (5, n), the closures over all errors, and how arms and vectors change.

    `matrix` is P in the middles (6, 5, n); `shift` is P_xyz over the intervals and `spin` W P_angles, both (3, 5, n);
    `turned` is dA'/da and `moved` dv/da, both (6, 3, 5, n).
    """

    errors: FloatArray
    matrix: FloatArray
    hull: Motion
    shift: Enclosure
    spin: Enclosure
    turned: Enclosure
    moved: Enclosure


def erring(machine: Machine, boxes: Boxes, found: Inclusions) -> Erring | None:
    """Evaluate boxes for all errors of their actuators; None if there are none."""
    following = found.following
    if following is None:
        return None
    pose, q = boxes.over.pose, boxes.over.q
    hull = follow(
        machine,
        constant(pose, total(pose.rad[0], following.moved, found.image)),
        constant(q, total(q.rad[0], following.errors)),
    )
    P = following.over
    axes, arms = hull.axes[0], hull.arms[0]
    spin = contract("jcn,jan->can", axes, P[3:], 3)
    across = cross(spread(axes, 0), spread(arms, 1), axis=2)
    turned = contract("ljcn,jan->lcan", across, P[3:], 3)
    moved = turned + Enclosure(P.mid[None, :3], P.rad[None, :3]) - exactly(_with_carts(hull)[..., None])
    return Erring(following.errors, following.matrix[0], hull, P[:3], spin, turned, moved)


def statics_derivatives(machine: Machine, erring: Erring) -> Enclosure:
    """Enclose dH'/da over each box, shape (link, 6, error, n)."""
    hull = erring.hull
    arms, vectors, moments = (spread(part[0], 2) for part in (hull.arms, hull.vectors, hull.moments))
    turning = cross(erring.turned, vectors, axis=1) + cross(arms, erring.moved, axis=1)
    per_length = exactly(hull.characteristic_length).inverse()
    row = _joined(erring.moved, turning * per_length)
    inverse = hull.lengths[0].inverse()
    inverse = Enclosure(inverse.mid[:, None, None], inverse.rad[:, None, None])
    links = _joined(vectors, moments * per_length) * exactly(EXTENSIBLE[:, None, :, None])
    return row * inverse - links * (inverse * inverse)


def joint_moves(erring: Erring) -> Enclosure:
    """Enclose how cart joints, platform joints and rails move with each error, (15, 3, 5, n)."""
    n = erring.errors.shape[-1]
    carts, rails = np.zeros((6, 3, 5, n)), np.zeros((3, 3, 5, n))
    carts[:] = _with_carts(erring.hull)[..., None]
    platform = erring.moved + exactly(carts)
    mid = np.concatenate([carts, platform.mid, rails])
    return Enclosure(mid, np.concatenate([np.zeros_like(carts), platform.rad, rails]))


def _with_carts(hull: Motion) -> FloatArray:
    """Give how cart joints move with each actuator: along their rails with their own cart. Shape (6, 3, 5)."""
    moves: FloatArray = hull.rails[:, :, None] * OF_CART[:, None]
    return moves


def _joined(a: Enclosure, b: Enclosure) -> Enclosure:
    a_mid, a_rad = (np.broadcast_to(part, b.mid.shape) for part in (a.mid, a.rad))
    return Enclosure(np.concatenate([a_mid, b.mid], 1), np.concatenate([a_rad, b.rad], 1))
