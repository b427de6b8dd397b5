"""The closure equations along a piece of path, as power series in s with balls for coefficients.

With v_l = p + R a_l - C_l, A'_l = R a_l and moments m_l = A'_l x v_l, the closures and their derivatives by pose are

    f_l = (|v_l|^2 - len_l^2) / 2,    f_l' = [v_l ; E' m_l],    H column l = [v_l ; m_l / L] / len_l

with the characteristic length L and E = [e_x, y_platform, Rx e_z] the axes of rx, ry, rz. Axis a turns every axis b
that comes after it in R = Rx Rz Ry, so that second derivatives of R a_l are a x (b x A'_l).
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from flint import arb, arb_poly, arb_series, ctx

from pipeline.arrays import FloatArray
from pipeline.inclusion.pieces import exact
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, Machine

TERMS = 5
"""Terms kept of every power series: the residual is enclosed to order four in s, the Jacobian to order two."""

_LINKS = 6

Vector = list[arb_series]
"""A vector of series."""
N = TypeVar("N", arb, arb_series)

_OUTER_FIRST = (0, 2, 1)
"""Axes rx, rz, ry in the order in which they turn one another."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """A machine in balls; its floats are taken as exact.

    Attributes
    ----------
    points : 6 x 3
        a_l in the platform frame.
    anchors : 6 x 3
        C_l with the cart at q = 0: offset and rail.
    rails : 3 x 3
        Directions d_k of the rails; whatever rounding left of their length, carts move along them by q_k d_k.
    lengths : 6
        Lengths of the fixed links; None for the telescopes.
    characteristic_length : arb
        L, which moments are divided by.
    """

    points: list[list[arb]]
    anchors: list[list[arb]]
    rails: list[list[arb]]
    lengths: list[arb | None]
    characteristic_length: arb


@dataclass(frozen=True, eq=False)
class Closure(Generic[N]):
    """The closures and their parts, link by link, in series or in balls.

    Attributes
    ----------
    pose, q : 6, 5
        Pose and actuators.
    rotation : 3 x 3
        R.
    axes : 3 x 3
        e_x, y_platform, Rx e_z, in the order of rx, ry, rz.
    arms, vectors, moments : 6 x 3
        A'_l, v_l, m_l.
    lengths : 6
        Link lengths.
    rails : 6 x 3
        Direction of each link's rail.
    characteristic_length : arb
        L, which moments are divided by.
    """

    pose: list[N]
    q: list[N]
    rotation: list[list[N]]
    axes: list[list[N]]
    arms: list[list[N]]
    vectors: list[list[N]]
    moments: list[list[N]]
    lengths: list[N]
    rails: list[list[arb]]
    characteristic_length: arb

    def along_rails(self) -> list[N]:
        """Compute v_l . d of each link and its rail: by how much f_l falls with the cart's position."""
        return [component(v, rail) for v, rail in zip(self.vectors, self.rails, strict=True)]

    def residuals(self) -> list[N]:
        """Compute f_l of the six links."""
        return [(dot(v, v) - length * length) * _HALF for v, length in zip(self.vectors, self.lengths, strict=True)]

    def jacobian(self) -> list[list[N]]:
        """Compute the rows f_l' by (x, y, z, rx, ry, rz)."""
        rows: list[list[N]] = []
        for link in range(_LINKS):
            turns: list[N] = [dot(axis, self.moments[link]) for axis in self.axes]
            rows.append(self.vectors[link] + turns)
        return rows

    def statics(self) -> list[list[N]]:
        """Compute H', whose row l is [v_l ; m_l / L] / len_l: where the links close, a unit vector and its moment."""
        rows: list[list[N]] = []
        for link in range(_LINKS):
            inverse: N = 1 / self.lengths[link]
            per_length: N = inverse / self.characteristic_length
            row: list[N] = [entry * inverse for entry in self.vectors[link]]
            row += [entry * per_length for entry in self.moments[link]]
            rows.append(row)
        return rows


_HALF = arb(0.5)


@contextmanager
def working_precision(bits: int) -> Iterator[None]:
    """Compute with the given number of bits, and with series of `TERMS` terms."""
    kept = ctx.cap
    ctx.cap = TERMS
    try:
        with ctx.workprec(bits):
            yield
    finally:
        ctx.cap = kept


def geometry(machine: Machine) -> Geometry:
    """Convert a machine to balls."""
    rails = np.column_stack([np.zeros(3), machine.rails_m])
    return Geometry(
        points=[[arb(value) for value in point] for point in machine.platform_points_m],
        anchors=[
            [arb(exact(b) + exact(rail)) for b, rail in zip(offset, rails[ARM_OF_LINK[link]], strict=True)]
            for link, offset in enumerate(machine.cart_offsets_m)
        ],
        rails=[[arb(value) for value in rail] for rail in machine.rail_directions.tolist()],
        lengths=[None if link in TELESCOPES else arb(length) for link, length in enumerate(machine.lengths_m)],
        characteristic_length=arb(machine.characteristic_length_m),
    )


def shifted(coefficients: list[arb], at: arb) -> arb_series:
    """Expand a polynomial about `at`; about a ball the series holds for every s in it."""
    if at.is_zero():
        return arb_series(coefficients[:TERMS], prec=TERMS)
    return arb_series(arb_poly(coefficients)(arb_poly([at, arb(1)])).coeffs()[:TERMS], prec=TERMS)


def pose_series(pose: FloatArray, at: arb) -> Vector:
    """Expand the six coordinates with Taylor coefficients pose (n, 6) about `at`."""
    return [shifted([arb(value) for value in column], at) for column in pose.T]


def closure(machine: Geometry, pose: list[N], q: list[N]) -> Closure[N]:
    """Evaluate the closures for pose and actuators, series or balls."""
    R, sx, cx = _rotation(*pose[3:]), pose[3].sin(), pose[3].cos()
    one, none = _constant(1, pose[0]), _constant(0, pose[0])
    arms, vectors = [], []
    for link, (point, anchor) in enumerate(zip(machine.points, machine.anchors, strict=True)):
        arm = [_combination(row, point, none) for row in R]
        arms.append(arm)
        tcp = _moved_against(pose, q[ARM_OF_LINK[link]], machine.rails[ARM_OF_LINK[link]])
        vectors.append([x + (a - c) for x, a, c in zip(tcp, arm, anchor, strict=True)])
    telescopes = iter(q[3:])
    return Closure(
        pose=pose,
        q=q,
        rotation=R,
        axes=[[one, none, none], [row[1] for row in R], [none, -sx, cx]],
        arms=arms,
        vectors=vectors,
        moments=[cross(arm, v) for arm, v in zip(arms, vectors, strict=True)],
        lengths=[next(telescopes) if length is None else length * one for length in machine.lengths],
        rails=[machine.rails[arm] for arm in ARM_OF_LINK],
        characteristic_length=machine.characteristic_length,
    )


def _moved_against(pose: list[N], cart: N, rail: list[arb]) -> list[N]:
    """Compute p - q d; coordinates that the rail does not go along are left as they are."""
    return [
        x if along.is_zero() else x - (cart if along == 1 else cart * along)
        for x, along in zip(pose[:3], rail, strict=True)
    ]


def component(vector: list[N], direction: list[arb]) -> N:
    """Compute the scalar product of a vector and constants, not all of them zero."""
    parts = [
        entry if weight == 1 else entry * weight
        for entry, weight in zip(vector, direction, strict=True)
        if not weight.is_zero()
    ]
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    return total


def second_derivatives(closure: Closure[arb]) -> list[list[arb]]:
    """Enclose the second derivatives of f_l by the pose: per link 36 balls, row by row."""
    hessians = []
    for arm, vector in zip(closure.arms, closure.vectors, strict=True):
        turned = [cross(axis, arm) for axis in closure.axes]
        entries = [arb(0)] * 36
        for i in range(3):
            entries[7 * i] = arb(1)
            for j in range(3):
                entries[6 * i + 3 + j] = entries[6 * (3 + j) + i] = turned[j][i]
        for position, i in enumerate(_OUTER_FIRST):
            for j in _OUTER_FIRST[position:]:
                entry = dot(turned[i], turned[j]) + dot(vector, cross(closure.axes[i], turned[j]))
                entries[6 * (3 + i) + 3 + j] = entries[6 * (3 + j) + 3 + i] = entry
        hessians.append(entries)
    return hessians


def _rotation(rx: N, ry: N, rz: N) -> list[list[N]]:
    """Compute R = Rx(rx) Rz(rz) Ry(ry), row by row."""
    (sx, cx), (sy, cy), (sz, cz) = ((angle.sin(), angle.cos()) for angle in (rx, ry, rz))
    szcy, szsy = sz * cy, sz * sy
    return [
        [cz * cy, -sz, cz * sy],
        [cx * szcy + sx * sy, cx * cz, cx * szsy - sx * cy],
        [sx * szcy - cx * sy, sx * cz, sx * szsy + cx * cy],
    ]


def _combination(row: list[N], weights: list[arb], none: N) -> N:
    total = none
    for entry, weight in zip(row, weights, strict=True):
        if not weight.is_zero():
            total = total + entry * weight
    return total


def _constant(value: int, like: N) -> N:
    return arb_series([arb(value)], prec=TERMS) if isinstance(like, arb_series) else arb(value)


def dot(a: list[N], b: list[N]) -> N:
    """Compute the scalar product of two vectors of balls or series."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: list[N], b: list[N]) -> list[N]:
    """Compute the vector product of two vectors of balls or series."""
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
