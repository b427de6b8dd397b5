"""What the machines of an ellipsoid change of the closures: the statement of `pipeline.inclusion.calibrated`."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import (
    Enclosure,
    bound,
    contract,
    cross,
    exactly,
    root,
    spread,
    times,
    total,
)
from pipeline.certify.recheck.arithmetic.motion import Motion
from pipeline.inclusion.calibrated.ellipsoid import FIXED, LENGTHS, OFFSETS, PLATFORM, RAILS, SCALES, ZEROS, Ellipsoid
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES

OFF_X = "the machines of an ellipsoid have rails along X"
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
    """Bound E, (6, n).

    Raises
    ------
    ValueError
        If a rail is off X.
    """
    if over.rails[:, 1:].any():
        raise ValueError(OFF_X)
    changes, sigma = link_changes(ellipsoid, over.q[0]), np.array(ellipsoid.sigma)
    first = times(row_norms(first_order(over, changes)), sigma)
    return total(first, second_order(over, changes, ellipsoid.sigma))


def preconditioned_change(hull: Motion, C: Enclosure, ellipsoid: Ellipsoid) -> FloatArray:
    """Bound |C dJ|, (6, 6, n), for C (6, 6, n)."""
    changes, k = link_changes(ellipsoid, hull.q[0]), np.array(ellipsoid.sigma)
    turned = turned_points(hull.rotation[0], changes)
    w = turned - changes.joints
    axes, arms, vectors = hull.axes[0], hull.arms[0], hull.vectors[0]
    first = cross(spread(axes, 0), spread(arms, 1), axis=2)
    second = cross(spread(vectors, 1), spread(axes, 0), axis=2)
    by_angle = contract("lacn,lcmn->lamn", first, w, 3) + contract("lacn,lcmn->lamn", second, turned, 3)
    rows = Enclosure(np.concatenate([w.mid, by_angle.mid], 1), np.concatenate([w.rad, by_angle.rad], 1))
    moved = contract("iln,lcmn->icmn", C, rows, 6)
    size = moved.magnitude
    linear = times(root(bound("icmn,icmn->icn", size, size, size.shape[2])), k)
    bent = times(operator_norms(w), k, times(operator_norms(changes.points), k))
    rest = bound("iln,ln->in", C.magnitude, bent, terms=6)
    return np.concatenate([linear[:, :3], total(linear[:, 3:], np.repeat(rest[:, None], 3, axis=1))], axis=1)


def operator_norms(M: Enclosure) -> FloatArray:
    """Bound ||M||_2 of matrices (k, 3, m, n) by the Frobenius norm of M M'. Shape (k, n)."""
    square = contract("kcmn,kdmn->kcdn", M, M, M.mid.shape[2]).magnitude
    return root(root(bound("kcdn,kcdn->kn", square, square, square.shape[1] ** 2)))


def row_norms(M: Enclosure) -> FloatArray:
    """Bound the Euclidean norms of rows (k, m, n). Shape (k, n)."""
    size = M.magnitude
    return root(bound("kmn,kmn->kn", size, size, size.shape[1]))
