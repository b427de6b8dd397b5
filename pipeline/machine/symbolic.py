"""The machine as CasADi functions: closure, joints and H, for gradient-based optimisation.

All take a pose (6,) = (x, y, z, rx, ry, rz) and actuator positions (5,). Links point along
u_l = (A_l - C_l) / |A_l - C_l|, the norm and not the given length: H is then the NumPy one whether or not the closure
holds, and does not depend on the telescopes, which leaves two columns of every Hessian empty.
"""

import casadi as ca
import numpy as np

from pipeline.machine.dynamics import carried_cart_masses, cart_weights
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, Machine
from pipeline.machine.masses import Masses, lumped_platform
from pipeline.machine.rails import rail_origins


def closure_function(machine: Machine) -> ca.Function:
    """Build (pose, q) -> residual (6,): (|A_l - C_l|^2 - len_l^2) / (2 L_l), by how many metres each link misses.

    L_l is the link's length, for telescopes that in the middle of the stroke, so that the residual is a polynomial
    in joints and lengths.
    """
    pose, q = _variables()
    vectors, _ = _links(machine, pose, q)
    lengths = ca.SX(machine.lengths_m)
    lengths[TELESCOPES] = q[3:]
    scale = machine.lengths_m.copy()
    scale[TELESCOPES] = machine.strokes_m.mean(axis=1)
    residual = (ca.sum1(vectors**2).T - lengths**2) / (2.0 * scale)
    return ca.Function("closure", [pose, q], [residual], ["pose", "q"], ["residual"])


def closure_terms_function(machine: Machine) -> ca.Function:
    """Build (z, v, w) -> F_z, F_zz[v, v], F_zz[v, w], F_zzz[v, v, v] of the closure F at z = (pose, q), (11,) each.

    They are what differentiating F(z(s)) = 0 up to three times by s is made of.
    """
    z, v, w = ca.SX.sym("z", 11), ca.SX.sym("v", 11), ca.SX.sym("w", 11)
    F = closure_function(machine)(z[:6], z[6:])
    along = ca.jtimes(F, z, v)
    twice = ca.jtimes(along, z, v)
    terms = [ca.densify(ca.jacobian(F, z)), twice, ca.jtimes(along, z, w), ca.jtimes(twice, z, v)]
    return ca.Function("closure_terms", [z, v, w], terms, ["z", "v", "w"], ["F_z", "vv", "vw", "vvv"])


def joints_function(machine: Machine) -> ca.Function:
    """Build (pose, q) -> platform joints A (6, 3) and cart joints C (6, 3), a row per link."""
    pose, q = _variables()
    platform, _ = _platform_joints(machine, pose)
    return ca.Function("joints", [pose, q], [platform.T, _cart_joints(machine, q).T], ["pose", "q"], ["A", "C"])


def statics_function(machine: Machine) -> ca.Function:
    """Build (pose, q) -> H of (1)-(2), (6, 6), as `statics.statics_matrix`."""
    pose, q = _variables()
    return ca.Function("statics", [pose, q], [_statics(machine, pose, q)], ["pose", "q"], ["H"])


def statics_terms_function(machine: Machine) -> ca.Function:
    """Build (z, W) -> the derivatives of H's entries (36,) by z (36, 9), and those of second order of W . H, (9, 9).

    z = (pose, carts): H does not depend on the telescopes. Entries of H and W (36,) are taken by columns.
    """
    z, W = ca.SX.sym("z", 9), ca.SX.sym("W", 36)
    entries = ca.vec(statics_function(machine)(z[:6], ca.vertcat(z[6:], 0.0, 0.0)))
    curvature, _ = ca.hessian(ca.dot(W, entries), z)
    terms = [ca.densify(ca.jacobian(entries, z)), ca.densify(curvature)]
    return ca.Function("statics_terms", [z, W], terms, ["z", "W"], ["by_z", "twice_by_z"])


def holding_function(machine: Machine) -> ca.Function:
    """Build (pose, q, f) -> H f - w, (6,), and the forces of the drives, (5,), for forces f along the links, (6,).

    w is the wrench that holds the platform against gravity (`dynamics.holding_forces`).

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    masses = machine.known_masses
    body = lumped_platform(masses, machine.platform_points_m)
    pose, q = _variables()
    f = ca.SX.sym("f", 6)
    F = ca.DM(-body.mass_kg * masses.gravity_mps2)
    r = rotation_matrix(pose[3], pose[4], pose[5]) @ ca.DM(body.centre_m)
    H = _statics(machine, pose, q)
    drives = _drives(machine, masses, H, f)
    wrench = ca.vertcat(F, ca.cross(r, F) / machine.characteristic_length_m)
    return ca.Function("holding", [pose, q, f], [H @ f - wrench, drives])


def rates_function(machine: Machine) -> ca.Function:
    """Build (z, z1, z2) -> first and second derivative by time of the closure, (6,) each.

    z = (pose, q) and its derivatives by time, (11,) each: zero where they are those of a motion of the machine.
    """
    z, z1, z2 = (ca.SX.sym(name, 11) for name in ("z", "z1", "z2"))
    rate = ca.jtimes(closure_function(machine)(z[:6], z[6:]), z, z1)
    acceleration = ca.jtimes(rate, z, z1) + ca.jtimes(rate, z1, z2)
    return ca.Function("rates", [z, z1, z2], [rate, acceleration])


def dynamics_function(machine: Machine) -> ca.Function:
    """Build (z, z1, z2, f) -> H f - w, (6,), and the forces of the drives, (5,), for forces f along the links, (6,).

    z = (pose, q) and its derivatives by time, (11,) each; w is the wrench that moves the platform, and friction is
    left out (`dynamics.inverse_dynamics`).

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    masses = machine.known_masses
    z, z1, z2 = (ca.SX.sym(name, 11) for name in ("z", "z1", "z2"))
    f = ca.SX.sym("f", 6)
    H = _statics(machine, z[:6], z[6:])
    drives = _drives(machine, masses, H, f) + ca.vertcat(ca.DM(carried_cart_masses(masses)) * z2[6:9], 0.0, 0.0)
    residual = H @ f - _wrench(machine, masses, (z, z1, z2))
    return ca.Function("dynamics", [z, z1, z2, f], [residual, drives])


def _wrench(machine: Machine, masses: Masses, motion: tuple[ca.SX, ca.SX, ca.SX]) -> ca.SX:
    """Write (F, M / L) of the platform by Newton's and Euler's equations about the TCP."""
    z, z1, z2 = motion
    body = lumped_platform(masses, machine.platform_points_m)
    rates, R = z1[3:6], rotation_matrix(z[3], z[4], z[5])
    axes = rotation_axes(z)
    omega, alpha = axes @ rates, axes @ z2[3:6] + axes_rate(axes, z, z1) @ rates
    r, inertia = R @ ca.DM(body.centre_m), R @ ca.DM(body.inertia_kgm2) @ R.T
    acceleration = z2[:3] + ca.cross(alpha, r) + ca.cross(omega, ca.cross(omega, r))
    F = body.mass_kg * (acceleration - ca.DM(masses.gravity_mps2))
    M = ca.cross(r, F) + inertia @ alpha + ca.cross(omega, inertia @ omega)
    return ca.vertcat(F, M / machine.characteristic_length_m)


def _drives(machine: Machine, masses: Masses, H: ca.SX, f: ca.SX) -> ca.SX:
    """Forces of drives that keep carts still: the first rows of H hold u_l."""
    directions = ca.sparsify(ca.DM(machine.rail_directions[ARM_OF_LINK].T))
    along = f * ca.densify(ca.sum1(H[:3, :] * directions)).T
    carts = [ca.sum1(along[np.flatnonzero(arm == ARM_OF_LINK).tolist()]) for arm in range(3)]
    weights = ca.vertcat(ca.DM(cart_weights(machine, masses)), 0.0, 0.0)
    return ca.vertcat(*carts, f[TELESCOPES.tolist()]) + weights


def _variables() -> tuple[ca.SX, ca.SX]:
    return ca.SX.sym("pose", 6), ca.SX.sym("q", 5)


def rotation_matrix(rx: ca.SX, ry: ca.SX, rz: ca.SX) -> ca.SX:
    """Build R = Rx(rx) Rz(rz) Ry(ry), (3, 3)."""
    cx, sx, cy, sy, cz, sz = ca.cos(rx), ca.sin(rx), ca.cos(ry), ca.sin(ry), ca.cos(rz), ca.sin(rz)
    return ca.vertcat(
        ca.horzcat(cz * cy, -sz, cz * sy),
        ca.horzcat(cx * sz * cy + sx * sy, cx * cz, cx * sz * sy - sx * cy),
        ca.horzcat(sx * sz * cy - cx * sy, sx * cz, sx * sz * sy + cx * cy),
    )


def rotation_axes(pose: ca.SX) -> ca.SX:
    """Stack the axes e_x, y_platform and Rx e_z that rx, ry and rz turn about, (3, 3)."""
    rx, ry, rz = pose[3], pose[4], pose[5]
    z_axis = ca.vertcat(0.0, -ca.sin(rx), ca.cos(rx))
    return ca.horzcat(ca.DM([1.0, 0.0, 0.0]), rotation_matrix(rx, ry, rz)[:, 1], z_axis)


def axes_rate(axes: ca.SX, pose: ca.SX, rate: ca.SX) -> ca.SX:
    """Differentiate `rotation_axes` (3, 3) by time, at a rate of the pose."""
    return ca.reshape(ca.jtimes(ca.vec(axes), pose, rate), 3, 3)


def _platform_joints(machine: Machine, pose: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Joints A_l and arms A'_l = R a_l, both (3, 6)."""
    # Sparse, so that the zeros of the geometry leave no trace in the expression.
    points = ca.sparsify(ca.DM(machine.platform_points_m.T))
    arms = ca.densify(rotation_matrix(pose[3], pose[4], pose[5]) @ points)
    return ca.repmat(pose[:3], 1, 6) + arms, arms


def _cart_joints(machine: Machine, q: ca.SX) -> ca.SX:
    """C_l, (3, 6)."""
    fixed = machine.cart_offsets_m + rail_origins(machine)[ARM_OF_LINK]
    # Sparse, so that parallel rails leave no trace of Y and Z.
    along = [ca.sparsify(ca.DM(machine.rail_directions[int(arm)])) * q[int(arm)] for arm in ARM_OF_LINK]
    return ca.DM(fixed.T) + ca.horzcat(*along)


def _links(machine: Machine, pose: ca.SX, q: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Vectors A_l - C_l and arms A'_l, both (3, 6)."""
    platform, arms = _platform_joints(machine, pose)
    vectors: ca.SX = platform - _cart_joints(machine, q)
    return vectors, arms


def _statics(machine: Machine, pose: ca.SX, q: ca.SX) -> ca.SX:
    vectors, arms = _links(machine, pose, q)
    columns = []
    for link in range(6):
        u = vectors[:, link] / ca.norm_2(vectors[:, link])
        columns.append(ca.vertcat(u, ca.cross(arms[:, link], u) / machine.characteristic_length_m))
    return ca.horzcat(*columns)
