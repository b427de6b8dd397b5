"""The closures along the cubics of many boxes, as arrays with orders first and boxes last."""

from dataclasses import dataclass
from functools import partial
from operator import mul

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, contract, cross, dot, exactly, stacked
from pipeline.certify.recheck.arithmetic.jets import TERMS, product, sine_cosine
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, Machine

_OUTER = np.array([[0, 0, 0], [0, 1, 2], [0, 2, 2]])
"""Which of two axes turns the other, for pairs of rx, ry, rz."""
_INNER = np.array([[0, 1, 2], [1, 1, 1], [2, 1, 2]])


@dataclass(frozen=True, eq=False)
class Motion:
    """Series of the closures and their parts.

    Attributes
    ----------
    pose, q : (orders, 6, n), (orders, 5, n)
        Pose and actuators.
    rotation : (orders, 3, 3, n)
        R.
    axes : (orders, 3, 3, n)
        The axes of rx, ry, rz, row by row.
    arms, vectors, moments : (orders, 6, 3, n)
        R a_l, v_l and R a_l x v_l.
    lengths : (orders, 6, n)
        Link lengths.
    rails : (6, 3)
        Direction of each link's rail.
    characteristic_length : float
        L, which moments are divided by.
    """

    pose: Enclosure
    q: Enclosure
    rotation: Enclosure
    axes: Enclosure
    arms: Enclosure
    vectors: Enclosure
    moments: Enclosure
    lengths: Enclosure
    rails: FloatArray
    characteristic_length: float

    def residuals(self) -> Enclosure:
        """Compute f_l, shape (orders, 6, n)."""
        squares = product(partial(dot, axis=1), self.vectors, self.vectors)
        difference = squares - product(mul, self.lengths, self.lengths)
        return difference * exactly(0.5)

    def jacobian(self) -> Enclosure:
        """Compute f_l', shape (orders, 6, 6, n)."""
        return _beside(self.vectors, product(_onto_axes, self.axes, self.moments))

    def statics(self) -> Enclosure:
        """Compute H', shape (orders, 6, 6, n)."""
        inverse = _reciprocal(self.lengths)
        each = Enclosure(inverse.mid[:, :, None], inverse.rad[:, :, None])
        moments = self.moments * exactly(self.characteristic_length).inverse()
        return product(mul, _beside(self.vectors, moments), each)


def follow(machine: Machine, pose: Enclosure, q: Enclosure) -> Motion:
    """Evaluate everything for series of pose (orders, 6, n) and actuators (orders, 5, n)."""
    n = pose.mid.shape[-1]
    rotation, axes = _turning(pose[:, 3:])
    arms = contract("oijn,lj->olin", rotation, exactly(machine.platform_points_m), 3)
    rails = np.column_stack([np.zeros(3), machine.rails_m])[ARM_OF_LINK]
    constant = exactly(machine.cart_offsets_m) + exactly(rails)
    anchors = _constants(constant, n)
    directions = machine.rail_directions[ARM_OF_LINK]
    tcp = Enclosure(pose.mid[:, None, :3], pose.rad[:, None, :3])
    vectors = (tcp - on_rails(q[:, ARM_OF_LINK], directions)) + (arms - anchors)
    lengths = _constants(exactly(np.nan_to_num(machine.lengths_m)), n)
    lengths.mid[:, TELESCOPES], lengths.rad[:, TELESCOPES] = q.mid[:, 3:], q.rad[:, 3:]
    moments = product(partial(cross, axis=1), arms, vectors)
    return Motion(
        pose=pose,
        q=q,
        rotation=rotation,
        axes=axes,
        arms=arms,
        vectors=vectors,
        moments=moments,
        lengths=lengths,
        rails=directions,
        characteristic_length=machine.characteristic_length_m,
    )


def on_rails(positions: Enclosure, rails: FloatArray) -> Enclosure:
    """Turn positions (..., m, n) along rails (m, 3) into vectors q d, (..., m, 3, n)."""
    if rails[:, 1:].any():
        return Enclosure(positions.mid[..., None, :], positions.rad[..., None, :]) * exactly(rails[..., None])
    *shape, n = positions.mid.shape
    mid, rad = np.zeros((*shape, 3, n)), np.zeros((*shape, 3, n))
    mid[..., 0, :], rad[..., 0, :] = positions.mid, positions.rad
    return Enclosure(mid, rad)


def along_rails(vectors: Enclosure, rails: FloatArray) -> Enclosure:
    """Compute v . d of vectors (..., m, 3, n) and the directions of their rails (m, 3). Shape (..., m, n)."""
    if rails[:, 1:].any():
        return contract("...mcn,mc->...mn", vectors, exactly(rails), 3)
    return vectors[..., 0, :]


def second_derivatives(motion: Motion) -> Enclosure:
    """Compute f_l'' of the constant terms, shape (link, 6, 6, n)."""
    axes, arms, vectors = motion.axes[0], motion.arms[0], motion.vectors[0]
    turned = cross(_each(axes, 0), _each(arms, 1), axis=2)
    outer, inner = _pick(_each(axes, 0), _OUTER, 1), _pick(turned, _INNER, 1)
    bent = cross(outer, inner, axis=3)
    by_two = dot(_each(turned, 2), _each(turned, 1), axis=3) + dot(_each(_each(vectors, 1), 1), bent, axis=3)
    shape = (6, 6, 6, arms.mid.shape[-1])
    mid, rad = np.zeros(shape), np.zeros(shape)
    for i in range(3):
        mid[:, i, i] = 1.0
    mid[:, 3:, :3], rad[:, 3:, :3] = turned.mid, turned.rad
    mid[:, :3, 3:], rad[:, :3, 3:] = turned.mid.swapaxes(1, 2), turned.rad.swapaxes(1, 2)
    mid[:, 3:, 3:], rad[:, 3:, 3:] = by_two.mid, by_two.rad
    return Enclosure(mid, rad)


def _turning(angles: Enclosure) -> tuple[Enclosure, Enclosure]:
    """Compute R = Rx Rz Ry and the axes of rx, ry, rz."""
    sine, cosine = sine_cosine(angles)
    (sx, sy, sz), (cx, cy, cz) = ([part[:, k] for k in range(3)] for part in (sine, cosine))
    none = exactly(np.zeros_like(sx.mid))
    one = exactly(np.concatenate([np.ones_like(sx.mid[:1]), np.zeros_like(sx.mid[1:])]))
    Rx = _matrix([[one, none, none], [none, cx, -sx], [none, sx, cx]])
    Rz = _matrix([[cz, -sz, none], [sz, cz, none], [none, none, one]])
    Ry = _matrix([[cy, none, sy], [none, one, none], [-sy, none, cy]])
    tilted = product(_times, Rx, Rz)
    rotation = product(_times, tilted, Ry)
    axes = stacked([stacked([one, none, none], 1), rotation[:, :, 1], Rx[:, :, 2]], 1)
    return rotation, axes


def _times(a: Enclosure, b: Enclosure) -> Enclosure:
    return contract("ijn,jkn->ikn", a, b, 3)


def _onto_axes(axes: Enclosure, moments: Enclosure) -> Enclosure:
    return contract("ain,lin->lan", axes, moments, 3)


def _each(values: Enclosure, axis: int) -> Enclosure:
    """Add an axis along which values are repeated."""
    return Enclosure(np.expand_dims(values.mid, axis), np.expand_dims(values.rad, axis))


def _pick(values: Enclosure, table: IntArray, axis: int) -> Enclosure:
    """Select along an axis by a table of indices, whose two axes take its place."""
    return Enclosure(values.mid.take(table, axis), values.rad.take(table, axis))


def _matrix(rows: list[list[Enclosure]]) -> Enclosure:
    return stacked([stacked(row, 1) for row in rows], 1)


def _constants(values: Enclosure, n: int) -> Enclosure:
    """Make constant series, the same for all n boxes."""
    mid, rad = (np.zeros((TERMS, *values.mid.shape, n)) for _ in range(2))
    mid[0], rad[0] = values.mid[..., None], values.rad[..., None]
    return Enclosure(mid, rad)


def _beside(left: Enclosure, right: Enclosure) -> Enclosure:
    return Enclosure(np.concatenate([left.mid, right.mid], 2), np.concatenate([left.rad, right.rad], 2))


def _reciprocal(series: Enclosure) -> Enclosure:
    """Compute 1 / x: r_0 = 1 / x_0, r_n = -r_0 sum x_k r_(n-k)."""
    first = series[0].inverse()
    result = [first]
    for n in range(1, TERMS):
        value = series[1] * result[n - 1]
        for k in range(2, n + 1):
            value = value + series[k] * result[n - k]
        result.append(-(first * value))
    return stacked(result)
