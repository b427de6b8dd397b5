"""Holding forces in actuator space and their derivatives: the stiffness that gravity gives the axes, or takes.

Both are derivatives of the potential energy V(q) = -m g . (p + R c) of the lumped platform, c being its centre of mass
from the TCP: F = dV/dq and K = dF/dq = d2V/dq2. Carts on rails that rise add what is linear in q.
"""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.actuator_space.rates import EXTENSIONS, ActuatorRates, solve_regular
from pipeline.machine.dynamics import cart_weights
from pipeline.machine.geometry import Machine, cross
from pipeline.machine.masses import lumped_platform


def gravity_forces(machine: Machine, rates: ActuatorRates) -> FloatArray:
    """Compute the forces of the five drives that hold the machine: T' w with the twist T. In N, shape (n, 5).

    w = (F0, c x F0) is the wrench on the platform, F0 = -m g; carts' drives hold their part along the rails, too. The
    same as `dynamics.holding_forces`.

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    weight, centre = _weight(machine, rates)
    wrench = np.concatenate([weight, cross(centre, weight)], axis=-1)
    forces = np.einsum("nij,ni->nj", rates.twist, wrench)
    forces[:, :3] += cart_weights(machine, machine.known_masses)
    return np.asarray(forces)


def gravity_stiffness(machine: Machine, rates: ActuatorRates) -> FloatArray:
    """Compute K = dF/dq of the holding forces, symmetric, in N/m, shape (n, 5, 5).

    With the links' holding forces f, their tips' velocities r_l relative to the carts, their extensions e_l and the
    platform's angular velocity W, all per actuator velocity,

        K = sum over links of f_l / len_l (e_l' e_l - r_l' r_l) + W' (S(F0, c) - sum of f_l S(u_l, A'_l)) W

    where S(a, b) = (a b' + b a') / 2 - (a . b) 1, so that w' S(a, b) w = a . (w x (w x b)). It is the acceleration of
    the platform at constant qd that the closures ask for, weighted by the links' forces: a pushed link (f_l > 0) tips
    over, a pulled one swings back.

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    weight, centre = _weight(machine, rates)
    wrench = np.concatenate([weight, cross(centre, weight) / machine.characteristic_length_m], axis=-1)
    link_n = solve_regular(rates.H, wrench[..., None])[..., 0]
    per_length = link_n / rates.lengths_m
    tips, spin = rates.tips, rates.spin
    weighted = (per_length[:, :, None, None] * tips).reshape(len(tips), 18, 5)
    K = -np.swapaxes(weighted, -1, -2) @ tips.reshape(len(tips), 18, 5)
    K += np.swapaxes(per_length[..., None] * EXTENSIONS, -1, -2) @ EXTENSIONS
    turning = _turning(weight[:, None], centre[:, None]) - _turning(link_n[..., None] * rates.directions, rates.arms)
    K += np.swapaxes(spin, -1, -2) @ turning @ spin
    return np.asarray((K + np.swapaxes(K, -1, -2)) / 2.0)


def least_stiffness(K: FloatArray) -> FloatArray:
    """Compute the least eigenvalue of stiffness matrices (n, 5, 5), in N/m, shape (n,); -inf where they hold NaN.

    It is not positive: all carts moved alike carry the machine along, and no force changes.
    """
    least = np.full(len(K), -np.inf)
    known = np.isfinite(K).all(axis=(1, 2))
    least[known] = np.linalg.eigvalsh(K[known])[:, 0]
    return least


def _weight(machine: Machine, rates: ActuatorRates) -> tuple[FloatArray, FloatArray]:
    """F0 = -m g and the centre of mass from the TCP, both (n, 3)."""
    masses = machine.known_masses
    body = lumped_platform(masses, machine.platform_points_m)
    centre = rates.rotation @ body.centre_m
    return np.broadcast_to(-body.mass_kg * masses.gravity_mps2, centre.shape), centre


def _turning(a: FloatArray, b: FloatArray) -> FloatArray:
    """Sum S(a, b) over vectors (n, k, 3). Shape (n, 3, 3)."""
    product = np.swapaxes(a, -1, -2) @ b
    trace = np.trace(product, axis1=-2, axis2=-1)
    return np.asarray((product + np.swapaxes(product, -1, -2)) / 2.0 - trace[:, None, None] * np.eye(3))
