"""Rigorous bounds of the forces that hold the machine, over a whole box.

The forces f along the links are the solution of f' H' = w', where row l of H' is that of link l (`Closure.statics`) and
w the wrench that holds the platform. With Y(t) an approximate inverse of H',

    f = Y' w + (I - H' Y)' f,   ||f|| <= ||Y' w|| / (1 - ||I - H' Y||),

and Y' w is a polynomial in t, whose range is sharp.
"""

import numpy as np
from flint import arb, arb_mat, arb_poly, arb_series

from pipeline.arrays import FloatArray
from pipeline.inclusion.closure import TERMS, Closure, Geometry, component, cross
from pipeline.inclusion.condition import above, below, frobenius, norm, statics_change
from pipeline.inclusion.displacement import of_pose
from pipeline.inclusion.krawczyk import linear_inverse, residual_of_inverse
from pipeline.inclusion.matrices import ball_matrix, inner, magnitudes, matrices
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.inclusion.ranges import polynomial_range
from pipeline.machine.dynamics import carried_cart_masses
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES
from pipeline.machine.masses import Masses, lumped_platform

_LINKS = 6


def holding_force_ranges(box: ProvenBox, masses: Masses) -> FloatArray:
    """Bound the forces of the five drives and along the six links from below and above. Shape (11, 2), in newtons.

    Infinite if H may be singular.
    """
    unknown = np.tile([-np.inf, np.inf], (11, 1))
    series, h, deviation = box.series, box.series.half, box.inclusion.image
    H = matrices(series.at.statics(), series.over.statics(), 3)
    Y = linear_inverse(H)
    if Y is None:
        return unknown
    transposed = [ball_matrix(part.T) for part in Y]
    miss = residual_of_inverse(transposed, [part.transpose() for part in H], h)
    vectors = [[entry[0] for entry in vector] for vector in series.over.vectors]
    off = statics_change(
        box.balls, (vectors, [length[0] for length in series.over.lengths]), of_pose(box.balls, deviation)
    )
    bound_Y = frobenius(magnitudes(transposed[0])) + h * frobenius(magnitudes(transposed[1]))
    loss = frobenius(miss) + bound_Y * off
    if not loss < 1:
        return unknown
    wrenches, turned_by = _wrenches(box, masses)
    links = _products(transposed, wrenches)
    moved = bound_Y * turned_by
    size = (norm([_magnitude(force, h) for force in links]) + moved) / (1 - loss)
    by_pose = bound_Y * off * size + moved
    # First with the norm of the forces, then with the bound of each.
    errors = [norm(row) * size + by_pose for row in miss]
    each = [_magnitude(force, h) + error for force, error in zip(links, errors, strict=True)]
    errors = [inner(row, each) + by_pose for row in miss]
    rows = _terms(series.at, series.over)
    carts, cart_errors = [arb_poly([weight]) for weight in cart_weights(box.balls, masses)], [arb(0)] * 3
    for link, arm in enumerate(ARM_OF_LINK.tolist()):
        carts[arm] = carts[arm] + links[link] * arb_poly(rows[link])
        along, change = _magnitude(arb_poly(rows[link]), h), off * norm(series.over.rails[link])
        cart_errors[arm] = cart_errors[arm] + errors[link] * (along + change) + size * change
    forces = [*carts, *(links[link] for link in TELESCOPES.tolist()), *links]
    spread = [*cart_errors, *(errors[link] for link in TELESCOPES.tolist()), *errors]
    return np.array([_range(force, h, error) for force, error in zip(forces, spread, strict=True)])


def _wrenches(box: ProvenBox, masses: Masses) -> tuple[list[arb_poly], arb]:
    """Compute the wrench (F, r x F / L) along the box's cubic, and bound how far it changes with the pose of the box.

    L is the characteristic length.
    """
    per_length = 1 / box.balls.characteristic_length
    body = lumped_platform(masses, box.machine.platform_points_m)
    F = [arb(value) for value in (-body.mass_kg * masses.gravity_mps2).tolist()]
    centre = [arb(value) for value in body.centre_m.tolist()]
    at, over = (
        [row[0] * centre[0] + row[1] * centre[1] + row[2] * centre[2] for row in motion.rotation]
        for motion in (box.series.at, box.series.over)
    )
    arms = [[(over if n + 1 == TERMS else at)[axis][n] for axis in range(3)] for n in range(TERMS)]
    moments = [cross(arm, F) for arm in arms]
    wrench = [arb_poly([force]) for force in F]
    wrench += [arb_poly([moment[axis] * per_length for moment in moments]) for axis in range(3)]
    turn = sum((d.abs_upper() for d in box.inclusion.image[3:]), arb(0))
    return wrench, norm(centre) * turn * norm(F) * per_length


def _terms(at: Closure[arb_series], over: Closure[arb_series]) -> list[list[arb]]:
    """Return u . d of each link and its rail: coefficients about the middle, the last one over the interval."""
    first, last = (
        [component(row[:3], rail) for row, rail in zip(motion.statics(), motion.rails, strict=True)]
        for motion in (at, over)
    )
    return [[(last if n + 1 == TERMS else first)[link][n] for n in range(TERMS)] for link in range(_LINKS)]


def cart_weights(machine: Geometry, masses: Masses) -> list[arb]:
    """Enclose the forces -m_k g . d_k that hold the carts on their rails (`dynamics.cart_weights`). Three balls."""
    gravity = [arb(value) for value in masses.gravity_mps2.tolist()]
    carried = carried_cart_masses(masses).tolist()
    return [-inner(gravity, rail) * arb(mass) for mass, rail in zip(carried, machine.rails, strict=True)]


def _products(matrix: list[arb_mat], vector: list[arb_poly]) -> list[arb_poly]:
    """Multiply (M0 + M1 t) by a vector of polynomials."""
    found = []
    for i in range(_LINKS):
        total = arb_poly([0])
        for j, part in enumerate(vector):
            total = total + arb_poly([matrix[0][i, j], matrix[1][i, j]]) * part
        found.append(total)
    return found


def _magnitude(polynomial: arb_poly, h: arb) -> arb:
    return sum((value.abs_upper() * h**n for n, value in enumerate(polynomial.coeffs())), arb(0))


def _range(polynomial: arb_poly, h: arb, error: arb) -> tuple[float, float]:
    least, largest = polynomial_range(polynomial.coeffs() or [arb(0)], h)
    return below(least - error), above(largest + error)
