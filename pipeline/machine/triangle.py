"""The dependent angle ry: what the rigid triangle of links 3a and 3c does to the platform.

Both links start at cart 3, so their closures |A_l - C_l| = len_l tie ry to arm 3. With g = A_3a - C_3a,
w = a_3c - a_3a and d = b_3c - b_3a the difference of the two closures is

    (g - d) . R w = (len_3c^2 - len_3a^2 - |w|^2 - |d|^2) / 2 + g . d,

for the right-angled triangle u_3a . R w = 0. When a_3a lies on the platform's y axis, g does not depend on
ry and the equation reads A cos(ry) + B sin(ry) = C: a closed form. Otherwise cart 3 moves along with ry
and a root finder is needed. Where |C| = hypot(A, B) two solutions meet: a Type-II singularity.
"""

import numpy as np
from scipy.optimize import elementwise

from pipeline.machine.geometry import (
    PRIMARY,
    TRIANGLE,
    FloatArray,
    Machine,
    rotation,
    rotation_x,
    rotation_z,
)

_SAMPLES = 72
_BLOCK = 20_000


def dependent_angle(machine: Machine, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """Compute ry in (-pi, pi] on the machine's assembly branch; NaN where arm 3 or the triangle cannot close.

    Parameters
    ----------
    controlled : (n, 5)
        x, y, z, rx, rz; x plays no role.
    signs : (n,)
        Working mode of arm 3: -1 for L, +1 for R.
    """
    on_axis = machine.platform_points_m[PRIMARY[2], [0, 2]]
    if not on_axis.any():
        return _closed_form(machine, controlled, signs)
    blocks = [
        _root_search(machine, controlled[i : i + _BLOCK], signs[i : i + _BLOCK])
        for i in range(0, len(controlled), _BLOCK)
    ]
    return np.concatenate(blocks) if blocks else np.empty(0)


def _closed_form(machine: Machine, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """Solve A cos(ry) + B sin(ry) = C with the a_3a taken on the platform's y axis."""
    rx, rz = controlled[:, 3], controlled[:, 4]
    Q = rotation_x(rx) @ rotation_z(rz)
    primary = PRIMARY[2]
    arm = Q[:, :, 1] * machine.platform_points_m[primary, 1]
    g = _arm3_vector(machine, controlled, arm, signs)
    w, d, constant = _triangle(machine)
    h = np.einsum("nji,nj->ni", Q, g - d)
    A = h[:, 0] * w[0] + h[:, 2] * w[2]
    B = h[:, 0] * w[2] - h[:, 2] * w[0]
    C = constant + g @ d - h[:, 1] * w[1]
    with np.errstate(invalid="ignore", divide="ignore"):
        opening = np.arccos(C / np.hypot(A, B))
    return _wrap(np.arctan2(B, A) - machine.triangle_sign * opening)


def _root_search(machine: Machine, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """Bracket every root of the triangle closure in ry, keep those on the branch, take the one nearest the closed form."""
    grid = np.linspace(-np.pi, np.pi, _SAMPLES + 1)
    values = np.stack([_mismatch(machine, np.full(len(controlled), ry), controlled, signs) for ry in grid], axis=1)
    with np.errstate(invalid="ignore"):
        row, column = np.nonzero(values[:, :-1] * values[:, 1:] < 0.0)
    found = elementwise.find_root(
        lambda ry, index: _mismatch(machine, ry, controlled[index], signs[index]),
        (grid[column], grid[column + 1]),
        args=(row,),
    )
    ry = found.x
    keep = found.success & (_branch(machine, ry, controlled[row], signs[row]) * machine.triangle_sign > 0.0)
    row, ry = row[keep], ry[keep]
    near = _closed_form(machine, controlled, signs)
    distance = np.abs(_wrap(ry - np.nan_to_num(near[row])))
    order = np.lexsort((distance, row))
    row, first = np.unique(row[order], return_index=True)
    result = np.full(len(controlled), np.nan)
    result[row] = _wrap(ry[order][first])
    return result


def _mismatch(machine: Machine, ry: FloatArray, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """Half of |A_3c - C_3c|^2 - len_3c^2 as a function of ry, cart 3 following in its working mode."""
    R = rotation(controlled[:, 3], ry, controlled[:, 4])
    g = _arm3_vector(machine, controlled, R @ machine.platform_points_m[PRIMARY[2]], signs)
    w, d, constant = _triangle(machine)
    value: FloatArray = np.einsum("ni,ni->n", g - d, R @ w) - constant - g @ d
    return value


def _branch(machine: Machine, ry: FloatArray, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """y_platform . (R w x g): its sign tells the two assemblies of the triangle apart."""
    R = rotation(controlled[:, 3], ry, controlled[:, 4])
    g = _arm3_vector(machine, controlled, R @ machine.platform_points_m[PRIMARY[2]], signs)
    w, d, _ = _triangle(machine)
    value: FloatArray = np.einsum("ni,ni->n", R[:, :, 1], np.cross(R @ w, g - d))
    return value


def _arm3_vector(machine: Machine, controlled: FloatArray, arm: FloatArray, signs: FloatArray) -> FloatArray:
    """g = A_3a - C_3a, shape (n, 3), NaN where link 3a does not reach its rail."""
    primary = PRIMARY[2]
    cross = controlled[:, 1:3] + arm[:, 1:] - machine.rails_m[2] - machine.cart_offsets_m[primary, 1:]
    D = machine.lengths_m[primary] ** 2 - np.sum(cross**2, axis=1)
    with np.errstate(invalid="ignore"):
        along = -signs * np.sqrt(D)
    return np.column_stack([along, cross])


def _triangle(machine: Machine) -> tuple[FloatArray, FloatArray, float]:
    """w, d and the constant of the triangle equation."""
    primary = PRIMARY[2]
    w = machine.platform_points_m[TRIANGLE] - machine.platform_points_m[primary]
    d = machine.cart_offsets_m[TRIANGLE] - machine.cart_offsets_m[primary]
    squares = machine.lengths_m[TRIANGLE] ** 2 - machine.lengths_m[primary] ** 2 - w @ w - d @ d
    return w, d, float(squares / 2.0)


def _wrap(angle: FloatArray) -> FloatArray:
    """Bring angles into (-pi, pi]."""
    wrapped: FloatArray = np.pi - np.mod(np.pi - angle, 2.0 * np.pi)
    return wrapped
