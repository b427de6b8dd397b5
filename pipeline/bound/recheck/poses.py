"""The machine at the poses of a box, in the world's frame: link vectors, carts, and H, as Taylor forms.

Poses are p = C_3a + L_3 Q (cos(beta) cos(alpha), sin(beta), cos(beta) sin(alpha)) - R a_3a with R = Q Ry(psi - alpha),
Q = Rx Rz: everything else is the definition of the machine, A_l = p + R a_l and C_l on its cart.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.bound.recheck.taylor import Taylor, coordinate, cosine_sine, inverse_root, known
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, exactly
from pipeline.machine.geometry import ARM_OF_LINK, PRIMARY, TELESCOPES, TRIANGLE, Machine

Vector = list[Taylor]
_U = 2.0**-52


@dataclass(frozen=True, eq=False)
class Posed:
    """Arms R a_l and joints A_l from C_3a, for all links, and D_1, D_2, of boxes given by middles and half widths."""

    middle: FloatArray
    half: FloatArray
    arms: list[Vector]
    joints: list[Vector]
    D: list[Taylor]


def pose(machine: Machine, middle: FloatArray, half: FloatArray) -> Posed:
    """Place the platform for boxes (6, n); s_1 and s_2 play no role."""
    (ca, sa), (cb, sb), (cx, sx), (cz, sz) = (cosine_sine(k, middle, half) for k in range(4))
    zero = known(exactly(0.0), half)
    Q = [[cz, sz * -1.0, zero], [cx * sz, cx * cz, sx * -1.0], [sx * sz, sx * cz, cx]]
    w = machine.platform_points_m[TRIANGLE] - machine.platform_points_m[PRIMARY[2]]
    long = np.hypot(w[0], w[2])
    cp, sp = (_rounded(machine.triangle_sign * x / long) for x in (w[2], -w[0]))
    cy, sy = ca * cp + sa * sp, ca * sp - sa * cp
    arms = []
    for a in machine.platform_points_m.tolist():
        turned = [cy * a[0] + sy * a[2], known(exactly(a[1]), half), cy * a[2] - sy * a[0]]
        arms.append(_times(Q, turned))
    length = float(machine.lengths_m[PRIMARY[2]])
    third = [part * length for part in _times(Q, [cb * ca, sb, cb * sa])]
    joints = [[t + x - y for t, x, y in zip(third, arm, arms[PRIMARY[2]], strict=True)] for arm in arms]
    D = []
    for link in PRIMARY[:2].tolist():
        y, z = (joints[link][i] - known(_base(machine, link, i), half) for i in (1, 2))
        D.append(known(_rounded(float(machine.lengths_m[link]) ** 2), half) - y * y - z * z)
    return Posed(middle, half, arms, joints, D)


@dataclass(frozen=True, eq=False)
class Assembled:
    """Vectors of all links, carts 1 and 2 from cart 3, and D_k - s_k^2."""

    vectors: list[Vector]
    carts: list[Taylor]
    mismatch: list[Taylor]


def assemble(machine: Machine, at: Posed) -> Assembled:
    """Place the carts: v_k = (s_k, ...) for links 1 and 2a, and that of arm 3 is where it is."""
    half, offsets = at.half, machine.cart_offsets_m
    s = [coordinate(4 + k, at.middle, half) for k in range(2)]
    third = float(offsets[PRIMARY[2], 0])
    carts = [
        at.joints[link][0] - s[k] + known(_rounded(third - float(offsets[link, 0])), half)
        for k, link in enumerate(PRIMARY[:2].tolist())
    ]
    carts.append(known(exactly(0.0), half))
    vectors = []
    for link, joint in enumerate(at.joints):
        arm = int(ARM_OF_LINK[link])
        x = joint[0] - carts[arm] - known(_rounded(float(offsets[link, 0]) - third), half)
        vectors.append([x, *(joint[i] - known(_base(machine, link, i), half) for i in (1, 2))])
    return Assembled(vectors, carts[:2], [D - each * each for D, each in zip(at.D, s, strict=True)])


def square(v: Vector) -> Taylor:
    """Compute |v|^2."""
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]


def statics(machine: Machine, at: Posed, found: Assembled) -> list[Vector]:
    """Compute the columns [u_l ; A'_l x u_l / L] of H, six entries each."""
    shortest = dict(zip(TELESCOPES.tolist(), machine.strokes_m[:, 0].tolist(), strict=True))
    lengths = machine.lengths_m.copy()
    side = machine.platform_points_m[TRIANGLE] - machine.platform_points_m[PRIMARY[2]]
    lengths[TRIANGLE] = np.hypot(lengths[PRIMARY[2]], np.linalg.norm(side))
    unit = _rounded(1.0 / machine.characteristic_length_m)
    columns = []
    for link, v in enumerate(found.vectors):
        if link in shortest:
            by = inverse_root(square(v), 0.25 * shortest[link] ** 2)
            u = [part * by for part in v]
        else:
            u = [part * _rounded(1.0 / float(lengths[link])) for part in v]
        a = at.arms[link]
        moment = [
            (a[1] * u[2] - a[2] * u[1]) * unit,
            (a[2] * u[0] - a[0] * u[2]) * unit,
            (a[0] * u[1] - a[1] * u[0]) * unit,
        ]
        columns.append([*u, *moment])
    return columns


def _times(M: list[Vector], v: Vector) -> Vector:
    return [row[0] * v[0] + row[1] * v[1] + row[2] * v[2] for row in M]


def _base(machine: Machine, link: int, axis: int) -> Enclosure:
    """Place C_l from C_3a across the rails, y or z."""
    third = int(PRIMARY[2])
    rails = machine.rails_m[ARM_OF_LINK]
    parts = (
        rails[link, axis - 1],
        -rails[third, axis - 1],
        machine.cart_offsets_m[link, axis],
        -machine.cart_offsets_m[third, axis],
    )
    return Enclosure(np.asarray(sum(parts), dtype=float), np.asarray(4.0 * _U * np.abs(parts).sum()))


def _rounded(value: float) -> Enclosure:
    """Enclose what was computed with a few roundings."""
    return Enclosure(np.asarray(value, dtype=float), np.asarray(8.0 * _U * abs(value)))
