"""What the machines of an ellipsoid change of the closures: the statement of `pipeline.inclusion.calibrated`."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, bound, contract, exactly, root, times, total
from pipeline.certify.recheck.arithmetic.motion import Motion
from pipeline.certify.recheck.arithmetic.norms import arm_lengths, norm
from pipeline.inclusion.calibrated.ellipsoid import FIXED, LENGTHS, OFFSETS, PLATFORM, RAILS, SCALES, ZEROS, Ellipsoid
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, Machine

_LINKS, _ARMS = 6, 3


@dataclass(frozen=True, eq=False)
class LinkChanges:
    """What u changes of the links over each box, m columns: da, dC (6, 3, m, n), dlen (6, m, n), actuators (5, m, n).

    `rails` is (3, 3, m): x is zero.
    """

    points: Enclosure
    joints: Enclosure
    lengths: Enclosure
    actuators: Enclosure
    rails: Enclosure


def link_changes(ellipsoid: Ellipsoid, q: Enclosure) -> LinkChanges:
    """Enclose what u changes where actuators are at q (5, n)."""
    W = ellipsoid.factor
    m, n = W.shape[1], q.mid.shape[-1]
    shown = (q - exactly(ellipsoid.zero_at_m[:, None])) * exactly(ellipsoid.scale[:, None]).inverse()
    by_scale = contract("am,an->amn", exactly(W[SCALES]), shown, 1)
    actuators = exactly(W[ZEROS][..., None]) + by_scale
    rails = np.concatenate([np.zeros((_ARMS, 1, m)), W[RAILS].reshape(_ARMS, 2, m)], axis=1)
    anchors = exactly(W[OFFSETS].reshape(_LINKS, 3, m)) + exactly(rails[ARM_OF_LINK])
    carts = along_x(actuators[ARM_OF_LINK])
    joints = Enclosure(anchors.mid[..., None], anchors.rad[..., None]) + carts
    mid, rad = np.zeros((_LINKS, m, n)), np.zeros((_LINKS, m, n))
    mid[list(FIXED)] = W[LENGTHS][..., None]
    mid[TELESCOPES], rad[TELESCOPES] = actuators.mid[_ARMS:], actuators.rad[_ARMS:]
    points = np.repeat(W[PLATFORM].reshape(_LINKS, 3, m)[..., None], n, axis=-1)
    return LinkChanges(exactly(points), joints, Enclosure(mid, rad), actuators, exactly(rails))


def along_x(rows: Enclosure) -> Enclosure:
    """Make rows (k, m, n) the x of three coordinates, (k, 3, m, n)."""
    none = np.zeros_like(rows.mid)
    return Enclosure(np.stack([rows.mid, none, none], 1), np.stack([rows.rad, none, none], 1))


def turned_points(rotation: Enclosure, changes: LinkChanges) -> Enclosure:
    """Compute R da, (6, 3, m, n)."""
    return contract("ijn,ljmn->limn", rotation, changes.points, 3)


def first_order(over: Motion, changes: LinkChanges) -> Enclosure:
    """Enclose V over the intervals, (6, m, n)."""
    w = turned_points(over.rotation[0], changes) - changes.joints
    lengths = over.lengths[0]
    longer = changes.lengths * Enclosure(lengths.mid[:, None], lengths.rad[:, None])
    return contract("lin,limn->lmn", over.vectors[0], w, 3) - longer


def second_order(over: Motion, changes: LinkChanges, sigma: float) -> FloatArray:
    """Bound q, (6, n)."""
    w = times(operator_norms(turned_points(over.rotation[0], changes) - changes.joints), np.array(sigma))
    longer = times(row_norms(changes.lengths), np.array(sigma))
    return total(times(w, w), times(longer, longer)) * 0.5


def residual_change(over: Motion, ellipsoid: Ellipsoid) -> FloatArray:
    """Bound E, (6, n)."""
    changes, sigma = link_changes(ellipsoid, over.q[0]), np.array(ellipsoid.sigma)
    first = times(row_norms(first_order(over, changes)), sigma)
    return total(first, second_order(over, changes, ellipsoid.sigma))


def jacobian_change(machine: Machine, hull: Motion, ellipsoid: Ellipsoid) -> FloatArray:
    """Bound D, (6, 6, n)."""
    changes, sigma = link_changes(ellipsoid, hull.q[0]), np.array(ellipsoid.sigma)
    w = times(operator_norms(turned_points(hull.rotation[0], changes) - changes.joints), sigma)
    turned = times(operator_norms(changes.points), sigma)
    size = norm(np.moveaxis(hull.vectors[0].magnitude, 1, 0))
    by_angle = total(times(arm_lengths(machine)[:, None], w), times(total(size, w), turned))
    return np.concatenate([np.repeat(w[:, None], 3, axis=1), np.repeat(by_angle[:, None], 3, axis=1)], axis=1)


def operator_norms(M: Enclosure) -> FloatArray:
    """Bound ||M||_2 of matrices (k, 3, m, n) by the Frobenius norm of M M'. Shape (k, n)."""
    square = contract("kcmn,kdmn->kcdn", M, M, M.mid.shape[2]).magnitude
    return root(root(bound("kcdn,kcdn->kn", square, square, square.shape[1] ** 2)))


def row_norms(M: Enclosure) -> FloatArray:
    """Bound the Euclidean norms of rows (k, m, n). Shape (k, n)."""
    size = M.magnitude
    return root(bound("kmn,kmn->kn", size, size, size.shape[1]))
