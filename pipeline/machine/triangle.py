"""The dependent angle ry: what the rigid triangle of links 3a and 3c does to the platform.

Both links start at cart 3, so their closures |A_l - C_l| = len_l tie ry to arm 3. With g = A_3a - C_3a,
w = a_3c - a_3a and d = b_3c - b_3a the difference of the two closures is

    (g - d) . R w = (len_3c^2 - len_3a^2 - |w|^2 - |d|^2) / 2 + g . d,

for the right-angled triangle u_3a . R w = 0. When a_3a lies on the platform's y axis, g does not depend on
ry and the equation reads A cos(ry) + B sin(ry) = C: a closed form. Otherwise cart 3 moves along with ry
and a root finder is needed. Where |C| = hypot(A, B) two solutions meet and the machine may change from one assembly
branch to the other; without tilt the right-angled triangle has a Type-II singularity there.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import elementwise

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.machine.geometry import PRIMARY, TRIANGLE, Machine, cross, dot, rotation, turned
from pipeline.machine.pose import wrap_angle

_SAMPLES = 72
_FIRST_SAMPLE = -np.pi + 0.3 * 2.0 * np.pi / _SAMPLES
"""Chosen so that no sample falls on the multiples of five degrees that symmetric machines have for roots."""
_BLOCK = 20_000
_ARM3 = PRIMARY[2]


def dependent_angle(machine: Machine, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """Compute ry in (-pi, pi] on the machine's assembly branch; NaN where arm 3 or the triangle cannot close.

    Parameters
    ----------
    controlled : (n, 5)
        x, y, z, rx, rz; x plays no role.
    signs : (n,)
        Working mode of arm 3: -1 for L, +1 for R, 0 at its serial singularity, where both meet.
    """
    if on_axis(machine):
        return _closed_form(machine, controlled, signs)
    blocks = [
        _root_search(machine, controlled[i : i + _BLOCK], signs[i : i + _BLOCK])
        for i in range(0, len(controlled), _BLOCK)
    ]
    return np.concatenate(blocks) if blocks else np.empty(0)


def on_axis(machine: Machine) -> bool:
    """Tell whether a_3a lies on the platform's y axis, so that turning about it leaves arm 3 where it is."""
    return not machine.platform_points_m[_ARM3, [0, 2]].any()


def third_discriminant(machine: Machine, controlled: FloatArray, ry: FloatArray) -> FloatArray:
    """D_3 = L^2 - dy^2 - dz^2 of arm 3 for controlled poses (n, 5); `on_axis`, ry plays no role. Shape (n,)."""
    return _discriminant(machine, _across(machine, controlled, rotation(controlled[:, 3], ry, controlled[:, 4])))


def _closed_form(machine: Machine, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """Solve A cos(ry) + B sin(ry) = C for a_3a on the axis; NaN where there is no solution."""
    Q = rotation(controlled[:, 3], np.zeros(len(controlled)), controlled[:, 4])
    g, reached = _arm3_vector(machine, controlled, Q, signs)
    w, d, constant = _triangle(machine)
    h = [dot(Q[:, :, i], g - d) for i in range(3)]
    A = h[0] * w[0] + h[2] * w[2]
    B = h[0] * w[2] - h[2] * w[0]
    C = constant + dot(g, d) - h[1] * w[1]
    with np.errstate(invalid="ignore", divide="ignore"):
        opening = np.arccos(C / np.hypot(A, B))
    return np.where(reached, wrap_angle(np.arctan2(B, A) - machine.triangle_sign * opening), np.nan)


def _root_search(machine: Machine, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """Bracket the roots of the triangle closure in ry, keep those within reach and on the branch.

    Of several the one nearest the closed form is taken: the one that stays when the triangle moves onto the axis.
    """
    row, ry = _all_roots(machine, controlled, signs)
    R = rotation(controlled[row, 3], ry, controlled[row, 4])
    g, reached = _arm3_vector(machine, controlled[row], R, signs[row])
    keep = reached & (_branch(machine, R, g) * machine.triangle_sign > 0.0)
    row, ry = row[keep], ry[keep]
    near = np.nan_to_num(_closed_form(_moved_onto_axis(machine), controlled, signs))
    order = np.lexsort((np.abs(wrap_angle(ry - near[row])), row))
    row, first = np.unique(row[order], return_index=True)
    result = np.full(len(controlled), np.nan)
    result[row] = wrap_angle(ry[order][first])
    return result


def _moved_onto_axis(machine: Machine) -> Machine:
    points = machine.platform_points_m.copy()
    points[[_ARM3, TRIANGLE]] -= points[_ARM3] * [1.0, 0.0, 1.0]
    return replace(machine, platform_points_m=points)


def _all_roots(machine: Machine, controlled: FloatArray, signs: FloatArray) -> tuple[IntArray, FloatArray]:
    """Find the zeros of the mismatch over a full turn: the rows they belong to and the angles, both (roots,)."""
    grid = _FIRST_SAMPLE + np.linspace(0.0, 2.0 * np.pi, _SAMPLES + 1)
    values = [_mismatch(machine, np.full(len(controlled), ry), controlled, signs) for ry in grid]
    positive = np.stack(values, axis=1) >= 0.0
    row, column = np.nonzero(positive[:, :-1] != positive[:, 1:])

    def mismatch(ry: FloatArray, index: IntArray) -> FloatArray:
        return _mismatch(machine, ry, controlled[index], signs[index])

    found = elementwise.find_root(mismatch, (grid[column], grid[column + 1]), args=(row,))
    return row[found.success], found.x[found.success]


def _mismatch(machine: Machine, ry: FloatArray, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """Half of |A_3c - C_3c|^2 - len_3c^2 as a function of ry, cart 3 following in its working mode."""
    R = rotation(controlled[:, 3], ry, controlled[:, 4])
    g, _ = _arm3_vector(machine, controlled, R, signs)
    w, d, constant = _triangle(machine)
    return dot(g - d, turned(R, w)) - constant - dot(g, d)


def _branch(machine: Machine, R: FloatArray, g: FloatArray) -> FloatArray:
    """y_platform . (R w x (g - d)): its sign tells the two assemblies of the triangle apart."""
    w, d, _ = _triangle(machine)
    return dot(R[:, :, 1], cross(turned(R, w), g - d))


def _arm3_vector(
    machine: Machine, controlled: FloatArray, R: FloatArray, signs: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Compute g = A_3a - C_3a, shape (n, 3), and whether link 3a is long enough for it, shape (n,).

    Where it is not, g is continued with the cart abreast of the joint: that keeps the mismatch continuous, and
    no root beside the limit of reach is overlooked.
    """
    across = _across(machine, controlled, R)
    D = _discriminant(machine, across)
    g = np.stack([-signs * np.sqrt(np.maximum(D, 0.0)), across[:, 0], across[:, 1]]).T
    return g, (D >= 0.0) | (signs == 0.0)


def _discriminant(machine: Machine, across: FloatArray) -> FloatArray:
    D: FloatArray = machine.lengths_m[_ARM3] ** 2 - across[:, 0] ** 2 - across[:, 1] ** 2
    return D


def _across(machine: Machine, controlled: FloatArray, R: FloatArray) -> FloatArray:
    """How far joint A_3a is from C_3a along Y and Z. Shape (n, 2)."""
    across = turned(R, machine.platform_points_m[_ARM3])[:, 1:]
    across += controlled[:, 1:3] - machine.rails_m[2] - machine.cart_offsets_m[_ARM3, 1:]
    return across


def _triangle(machine: Machine) -> tuple[FloatArray, FloatArray, float]:
    """Read w, d and the constant of the triangle equation off the machine."""
    w = machine.platform_points_m[TRIANGLE] - machine.platform_points_m[_ARM3]
    d = machine.cart_offsets_m[TRIANGLE] - machine.cart_offsets_m[_ARM3]
    squares = machine.lengths_m[TRIANGLE] ** 2 - machine.lengths_m[_ARM3] ** 2 - w @ w - d @ d
    return w, d, float(squares / 2.0)
