"""The triangle closure as an equation for ry: its parts, and its closed form.

Both links start at cart 3, so their closures |A_l - C_l| = len_l tie ry to arm 3. With g = A_3a - C_3a,
w = a_3c - a_3a and d = b_3c - b_3a the difference of the two closures is

    (g - d) . R w = (len_3c^2 - len_3a^2 - |w|^2 - |d|^2) / 2 + g . d,

for the right-angled triangle u_3a . R w = 0. When a_3a lies on the platform's y axis, g does not depend on
ry and the equation reads A cos(ry) + B sin(ry) = C: a closed form.

All vectors here are along the axes of `rail_frame`, so that rail 3 is along x; on parallel rails these are X, Y and Z.
"""

from dataclasses import replace

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.machine.geometry import PRIMARY, TRIANGLE, Machine, rotation, turned
from pipeline.machine.pose import wrap_angle
from pipeline.machine.rails import rail_frame, rail_origins

ARM3 = PRIMARY[2]
"""The link whose joint decides where arm 3 is: 3a."""


def on_axis(machine: Machine) -> bool:
    """Tell whether a_3a lies on the platform's y axis, so that turning about it leaves arm 3 where it is."""
    return not machine.platform_points_m[ARM3, [0, 2]].any()


def third_discriminant(machine: Machine, controlled: FloatArray, ry: FloatArray) -> FloatArray:
    """D_3 = L^2 - dy^2 - dz^2 of arm 3 for controlled poses (n, 5); `on_axis`, ry plays no role. Shape (n,)."""
    return _discriminant(machine, _across(machine, controlled, orientation(machine, controlled, ry)))


def orientation(machine: Machine, controlled: FloatArray, ry: FloatArray) -> FloatArray:
    """T R, the orientation of the platform seen along rail 3, for controlled poses (n, 5). Shape (n, 3, 3)."""
    R = rotation(controlled[:, 3], ry, controlled[:, 4])
    return R if machine.has_parallel_rails else seen_along_rail(machine, R)


def seen_along_rail(machine: Machine, R: FloatArray) -> FloatArray:
    """T R for matrices or vectors (..., 3, k), stored like them."""
    turned_: FloatArray = np.einsum("ij,...jk->...ik", rail_frame(machine, 2), R)
    return turned_


def place_across(machine: Machine, controlled: FloatArray) -> FloatArray:
    """How far the TCP is from C_3a with the cart at q = 0, across rail 3. Shape (n, 2)."""
    if machine.has_parallel_rails:
        place: FloatArray = controlled[:, 1:3] - machine.rails_m[2] - machine.cart_offsets_m[ARM3, 1:]
        return place
    from_origin = controlled[:, :3] - rail_origins(machine)[2] - machine.cart_offsets_m[ARM3]
    across: FloatArray = from_origin @ rail_frame(machine, 2)[1:].T
    return across


def moved_onto_axis(machine: Machine) -> Machine:
    """Move a_3a straight to the platform's y axis, and a_3c with it."""
    points = machine.platform_points_m.copy()
    points[[ARM3, TRIANGLE]] -= points[ARM3] * [1.0, 0.0, 1.0]
    return replace(machine, platform_points_m=points)


def closed_form(machine: Machine, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """Solve A cos(ry) + B sin(ry) = C for a_3a on the axis; NaN where there is no solution."""
    Q = orientation(machine, controlled, np.zeros(len(controlled)))
    g, reached = arm3_vector(machine, controlled, Q, signs)
    A, B, C = coefficients(machine, np.moveaxis(Q, 0, -1), g.T)
    with np.errstate(invalid="ignore", divide="ignore"):
        opening = np.arccos(C / np.hypot(A, B))
    return np.where(reached, wrap_angle(np.arctan2(B, A) - machine.triangle_sign * opening), np.nan)


def coefficients(machine: Machine, Q: FloatArray, g: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Compute A, B and C from Q = Rx Rz (3, 3, n) and g (3, n) with a_3a on the axis. Three arrays (n,)."""
    w, d, constant = triangle_constants(machine)
    away = g - d[:, None]
    h = [Q[0, i] * away[0] + Q[1, i] * away[1] + Q[2, i] * away[2] for i in range(3)]
    A = h[0] * w[0] + h[2] * w[2]
    B = h[0] * w[2] - h[2] * w[0]
    return A, B, constant + (g[0] * d[0] + g[1] * d[1] + g[2] * d[2]) - h[1] * w[1]


def arm3_vector(
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
    D: FloatArray = machine.lengths_m[ARM3] ** 2 - across[:, 0] ** 2 - across[:, 1] ** 2
    return D


def _across(machine: Machine, controlled: FloatArray, R: FloatArray) -> FloatArray:
    """How far joint A_3a is from C_3a across rail 3. Shape (n, 2)."""
    across = turned(R, machine.platform_points_m[ARM3])[:, 1:]
    across += place_across(machine, controlled)
    return across


def triangle_constants(machine: Machine) -> tuple[FloatArray, FloatArray, float]:
    """Read w, d and the constant of the triangle equation off the machine."""
    w = machine.platform_points_m[TRIANGLE] - machine.platform_points_m[ARM3]
    d = machine.cart_offsets_m[TRIANGLE] - machine.cart_offsets_m[ARM3]
    if not machine.has_parallel_rails:
        d = rail_frame(machine, 2) @ d
    squares = machine.lengths_m[TRIANGLE] ** 2 - machine.lengths_m[ARM3] ** 2 - w @ w - d @ d
    return w, d, float(squares / 2.0)
