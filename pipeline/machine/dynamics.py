"""Inverse dynamics: the forces of drives and links that a motion takes.

Signs: a link's force is positive where it is pushed, and acts on the platform along u_l, from cart to platform; a
telescope's drive carries that very force. A cart's drive pushes it along its rail, d, which is X on parallel rails.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, Machine, cross, rotation, rotation_x
from pipeline.machine.masses import Masses, lumped_platform
from pipeline.machine.rails import along_rails
from pipeline.machine.statics import statics_matrix


@dataclass(frozen=True, eq=False)
class Forces:
    """Forces in newtons: of the drives c1, c2, c3, l2b, l3b (..., 5), and along the six links (..., 6)."""

    drive_n: FloatArray
    link_n: FloatArray


def carried_cart_masses(masses: Masses) -> FloatArray:
    """Mass of each cart with the halves of its links. Shape (3,)."""
    halves = np.zeros(3)
    np.add.at(halves, ARM_OF_LINK, masses.link_kg / 2.0)
    return masses.cart_kg + halves


def cart_weights(machine: Machine, masses: Masses) -> FloatArray:
    """Forces -m_k g . d_k that hold the carts with the halves of their links on their rails. Shape (3,), in newtons."""
    weights: FloatArray = -carried_cart_masses(masses) * (machine.rail_directions @ masses.gravity_mps2)
    return weights


def inverse_dynamics(
    machine: Machine,
    masses: Masses,
    pose: FloatArray,
    carts_m: FloatArray,
    pose_rate: FloatArray,
    pose_acceleration: FloatArray,
    cart_acceleration_mps2: FloatArray,
) -> Forces:
    """Compute the forces of a motion without friction, from Newton's and Euler's equations about the TCP.

    With the lumped platform's m, r (TCP to centre of mass) and I, and the machine's characteristic length L, the
    platform's wrench w and the links' forces f follow from

        m (a + alpha x r + omega x (omega x r) - g) = F
        r x F + I alpha + omega x I omega = M
        H f = w = (F, M / L)

    and a cart of carried mass m_k needs m_k (a_k - g . d_k) + sum of f_l u_l . d_k over its links.

    Parameters
    ----------
    pose, pose_rate, pose_acceleration : (n, 6)
        x, y, z, rx, ry, rz and their first two derivatives by time.
    carts_m, cart_acceleration_mps2 : (n, 3)
        Positions of the carts and their accelerations.
    """
    body = lumped_platform(masses, machine.platform_points_m)
    R = rotation(pose[:, 3], pose[:, 4], pose[:, 5])
    omega, alpha = angular_motion(pose, pose_rate, pose_acceleration)
    r = R @ body.centre_m
    inertia = R @ body.inertia_kgm2 @ np.swapaxes(R, -1, -2)
    centre_acceleration = pose_acceleration[:, :3] + cross(alpha, r) + cross(omega, cross(omega, r))
    F = body.mass_kg * (centre_acceleration - masses.gravity_mps2)
    M = cross(r, F) + _times(inertia, alpha) + cross(omega, _times(inertia, omega))
    H = statics_matrix(machine, pose, carts_m)
    wrench = np.concatenate([F, M / machine.characteristic_length_m], axis=1)
    link = np.linalg.solve(H, wrench[..., None])[..., 0]
    drive = _drive_forces(machine, masses, H, link)
    drive[:, :3] += carried_cart_masses(masses) * cart_acceleration_mps2
    return Forces(drive, link)


def holding_forces(machine: Machine, masses: Masses, pose: FloatArray, H: FloatArray) -> Forces:
    """Compute the forces that hold the machine against gravity, without friction: `inverse_dynamics` at rest.

    H f = (F, r x F / L) with F = -m g and the characteristic length L. Infinite where H is singular.

    Parameters
    ----------
    pose, H : (n, 6), (n, 6, 6)
        Poses and their statics matrices (1)-(2).
    """
    body = lumped_platform(masses, machine.platform_points_m)
    F = np.broadcast_to(-body.mass_kg * masses.gravity_mps2, (len(pose), 3))
    r = rotation(pose[:, 3], pose[:, 4], pose[:, 5]) @ body.centre_m
    wrench = np.concatenate([F, cross(r, F) / machine.characteristic_length_m], axis=1)
    try:
        link = np.linalg.solve(H, wrench[..., None])[..., 0]
        return Forces(_drive_forces(machine, masses, H, link), link)
    except np.linalg.LinAlgError:
        regular = np.linalg.det(H) != 0.0
    link, drive = np.full((len(pose), 6), np.inf), np.full((len(pose), 5), np.inf)
    link[regular] = np.linalg.solve(H[regular], wrench[regular][..., None])[..., 0]
    drive[regular] = _drive_forces(machine, masses, H[regular], link[regular])
    return Forces(drive, link)


def _drive_forces(machine: Machine, masses: Masses, H: FloatArray, link_n: FloatArray) -> FloatArray:
    """Forces of drives that keep carts still, for links' forces (n, 6): the first rows of H hold u_l. Shape (n, 5)."""
    along = link_n * along_rails(machine, H[:, :3].swapaxes(1, 2), ARM_OF_LINK)
    weights = cart_weights(machine, masses)
    carts = [along[:, arm == ARM_OF_LINK].sum(axis=1) + weights[arm] for arm in range(3)]
    return np.column_stack([*carts, link_n[:, TELESCOPES]])


def angular_motion(
    pose: FloatArray, pose_rate: FloatArray, pose_acceleration: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Angular velocity and acceleration (n, 3) for R = Rx(rx) Rz(rz) Ry(ry).

    omega = e_x rx_d + (Rx e_z) rz_d + y_platform ry_d; every axis is carried along by the rotations before it.
    """
    Rx = rotation_x(pose[:, 3])
    y_platform = rotation(pose[:, 3], pose[:, 4], pose[:, 5])[..., 1]
    rx, ry, rz = (pose_rate[:, k, None] for k in (3, 4, 5))
    rx2, ry2, rz2 = (pose_acceleration[:, k, None] for k in (3, 4, 5))
    axis_x = np.broadcast_to([1.0, 0.0, 0.0], (len(pose), 3))
    axis_z = Rx[..., 2]
    about_x = axis_x * rx
    about_xz = about_x + axis_z * rz
    omega = about_xz + y_platform * ry
    alpha = axis_x * rx2 + axis_z * rz2 + y_platform * ry2
    alpha += cross(about_x, axis_z) * rz + cross(about_xz, y_platform) * ry
    return omega, alpha


def _times(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    product: FloatArray = np.einsum("nij,nj->ni", matrices, vectors)
    return product
