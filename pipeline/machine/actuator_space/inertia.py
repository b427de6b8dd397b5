"""Inertia in actuator space: the mass that drives move, and the forces that velocities take."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.actuator_space.rates import EXTENSIONS, ActuatorRates, solve_regular
from pipeline.machine.dynamics import carried_cart_masses
from pipeline.machine.geometry import Machine, cross
from pipeline.machine.masses import lumped_platform


def mass_matrix(machine: Machine, rates: ActuatorRates) -> FloatArray:
    """Compute M of the kinetic energy qd' M qd / 2: T' M_p T with the twist T, plus the carts. In kg, (n, 5, 5).

    M_p is the mass matrix of the lumped platform about the TCP. M is symmetric and positive definite.

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    M = np.swapaxes(rates.twist, -1, -2) @ _platform_mass_matrix(machine, rates) @ rates.twist
    M = (M + np.swapaxes(M, -1, -2)) / 2.0
    M[:, [0, 1, 2], [0, 1, 2]] += carried_cart_masses(machine.known_masses)
    return np.asarray(M)


def velocity_forces(machine: Machine, rates: ActuatorRates, qd_mps: FloatArray) -> FloatArray:
    """Compute the forces c(q, qd) of a motion without acceleration of the actuators, less gravity. In N, (n, 5).

    They are T' (M_p t + b), with t the acceleration of the platform at qdd = 0, H' t = (len_d^2 - |r_d|^2) / len -
    u . (omega x (omega x A')) link by link, and b its centrifugal and gyroscopic wrench; quadratic in qd (n, 5).

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    body = lumped_platform(machine.known_masses, machine.platform_points_m)
    omega = np.einsum("nij,nj->ni", rates.spin, qd_mps)
    tips = np.einsum("nlij,nj->nli", rates.tips, qd_mps)
    extensions = qd_mps @ EXTENSIONS.T
    inward = np.cross(omega[:, None], np.cross(omega[:, None], rates.arms))
    needed = (extensions**2 - (tips**2).sum(axis=-1)) / rates.lengths_m - (rates.directions * inward).sum(axis=-1)
    platform = solve_regular(np.swapaxes(rates.H, -1, -2), needed[..., None])[..., 0]
    platform[:, 3:] /= machine.characteristic_length_m
    centre, inertia = _centre_and_inertia(machine, rates)
    force = body.mass_kg * cross(omega, cross(omega, centre))
    moment = cross(centre, force) + cross(omega, np.einsum("nij,nj->ni", inertia, omega))
    wrench = np.einsum("nij,nj->ni", _platform_mass_matrix(machine, rates), platform)
    wrench += np.concatenate([force, moment], axis=1)
    return np.asarray(np.einsum("nij,ni->nj", rates.twist, wrench))


def velocity_damping(machine: Machine, rates: ActuatorRates, qd_mps: FloatArray) -> FloatArray:
    """Compute dc/dqd at qd (n, 5), in Ns/m, shape (n, 5, 5); its symmetric part is dM/dt along the motion.

    c is quadratic in qd, so that central differences of any step are exact.

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    columns = [
        (velocity_forces(machine, rates, qd_mps + e) - velocity_forces(machine, rates, qd_mps - e)) / 2.0
        for e in np.eye(qd_mps.shape[1])
    ]
    return np.stack(columns, axis=-1)


def _centre_and_inertia(machine: Machine, rates: ActuatorRates) -> tuple[FloatArray, FloatArray]:
    """Centre of mass from the TCP (n, 3), and the inertia about it (n, 3, 3), along the axes of the room."""
    body = lumped_platform(machine.known_masses, machine.platform_points_m)
    R = rates.rotation
    return R @ body.centre_m, R @ body.inertia_kgm2 @ np.swapaxes(R, -1, -2)


def _platform_mass_matrix(machine: Machine, rates: ActuatorRates) -> FloatArray:
    """M_p for twists of the TCP: [[m 1, -m [c x]], [m [c x], I - m [c x]^2]]. Shape (n, 6, 6)."""
    mass_kg = lumped_platform(machine.known_masses, machine.platform_points_m).mass_kg
    centre, inertia = _centre_and_inertia(machine, rates)
    skew = np.cross(centre[:, None], -np.eye(3))
    M = np.zeros((len(centre), 6, 6))
    M[:, :3, :3] = mass_kg * np.eye(3)
    M[:, :3, 3:], M[:, 3:, :3] = -mass_kg * skew, mass_kg * skew
    M[:, 3:, 3:] = inertia - mass_kg * skew @ skew
    return M
