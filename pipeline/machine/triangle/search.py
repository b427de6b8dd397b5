"""The dependent angle ry off the axis, by a bracketed search over a full turn."""

import numpy as np
from scipy.optimize import elementwise

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine.geometry import Machine, cross, dot, turned
from pipeline.machine.pose import wrap_angle
from pipeline.machine.triangle.closure import (
    arm3_vector,
    closed_form,
    moved_onto_axis,
    orientation,
    triangle_constants,
)

_SAMPLES = 72
_FIRST_SAMPLE = -np.pi + 0.3 * 2.0 * np.pi / _SAMPLES
"""Chosen so that no sample falls on the multiples of five degrees that symmetric machines have for roots."""
_AT_ONCE = 20_000
"""Angles times poses that are evaluated at a time."""


def root_search(machine: Machine, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """Bracket the roots of the triangle closure in ry, keep those within reach and on the branch.

    Of several the one nearest the closed form is taken: the one that stays when the triangle moves onto the axis.
    """
    row, ry = _all_roots(machine, controlled, signs)
    R = orientation(machine, controlled[row], ry)
    g, reached = arm3_vector(machine, controlled[row], R, signs[row])
    keep = reached & (_branch(machine, R, g) * machine.triangle_sign > 0.0)
    row, ry = row[keep], ry[keep]
    near = np.nan_to_num(closed_form(moved_onto_axis(machine), controlled, signs))
    order = np.lexsort((np.abs(wrap_angle(ry - near[row])), row))
    row, first = np.unique(row[order], return_index=True)
    result = np.full(len(controlled), np.nan)
    result[row] = wrap_angle(ry[order][first])
    return result


def _all_roots(machine: Machine, controlled: FloatArray, signs: FloatArray) -> tuple[IntArray, FloatArray]:
    """Find the zeros of the mismatch over a full turn: the rows they belong to and the angles, both (roots,)."""
    grid = _FIRST_SAMPLE + np.linspace(0.0, 2.0 * np.pi, _SAMPLES + 1)
    count = len(controlled)
    at_once = max(1, _AT_ONCE // max(count, 1))
    values = []
    for i in range(0, len(grid), at_once):
        some = grid[i : i + at_once]
        every = np.tile(np.arange(count), len(some))
        found = mismatch(machine, np.repeat(some, count), controlled[every], signs[every])
        values.append(found.reshape(len(some), count))
    positive = np.concatenate(values).T >= 0.0
    row, column = np.nonzero(positive[:, :-1] != positive[:, 1:])

    def at(ry: FloatArray, index: IntArray) -> FloatArray:
        return mismatch(machine, ry, controlled[index], signs[index])

    found = elementwise.find_root(at, (grid[column], grid[column + 1]), args=(row,))
    return row[found.success], found.x[found.success]


def mismatch(machine: Machine, ry: FloatArray, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """Half of |A_3c - C_3c|^2 - len_3c^2 as a function of ry, cart 3 following in its working mode."""
    R = orientation(machine, controlled, ry)
    g, _ = arm3_vector(machine, controlled, R, signs)
    w, d, constant = triangle_constants(machine)
    return dot(g - d, turned(R, w)) - constant - dot(g, d)


def _branch(machine: Machine, R: FloatArray, g: FloatArray) -> FloatArray:
    """y_platform . (R w x (g - d)): its sign tells the two assemblies of the triangle apart."""
    w, d, _ = triangle_constants(machine)
    return dot(R[:, :, 1], cross(turned(R, w), g - d))
