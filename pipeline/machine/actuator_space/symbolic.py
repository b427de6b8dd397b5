"""The five equations as CasADi functions, derived from the closures by automatic differentiation.

All take a pose (6,) that closes the links for actuator positions q (5,); where closures are left, derivatives are those
of the residual's level set. Angles are those of R = Rx(rx) Rz(rz) Ry(ry), so that cos(rz) = 0 is excluded here.
"""

from dataclasses import dataclass

import casadi as ca

from pipeline.machine.dynamics import carried_cart_masses, cart_weights
from pipeline.machine.geometry import Machine
from pipeline.machine.masses import lumped_platform
from pipeline.machine.symbolic import (
    axes_rate,
    closure_function,
    closure_terms_function,
    rotation_axes,
    rotation_matrix,
)


@dataclass(frozen=True, eq=False)
class _Equations:
    """The terms of M qdd + c + g = F as expressions, the symbols they hold, and d(pose)/dq (6, 5)."""

    pose: ca.SX
    q: ca.SX
    qd: ca.SX
    pose_by_q: ca.SX
    mass: ca.SX
    velocity: ca.SX
    gravity: ca.SX


def equations_function(machine: Machine) -> ca.Function:
    """Build (pose, q, qd) -> M (5, 5), c(q, qd) (5,), g(q) (5,) of M qdd + c + g = F, and d(pose)/dq (6, 5).

    In kg, N, N and metres or radians per metre. Evaluate many poses at a time with `casadi.Function.map`.

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    of = _equations(machine)
    return ca.Function(
        "equations",
        [of.pose, of.q, of.qd],
        [of.mass, of.velocity, of.gravity, of.pose_by_q],
        ["pose", "q", "qd"],
        ["mass", "velocity", "gravity", "pose_by_q"],
    )


def stiffness_function(machine: Machine) -> ca.Function:
    """Build (pose, q) -> K (5, 5), the stiffness by gravity in N/m: `gravity_stiffness`.

    With the closures r(z) = 0 of z = (pose, q), their slope Z = dz/dq and multipliers f that balance the weight,
    dV/dpose + f' dr/dpose = 0, K is Z' (V + f' r)_zz Z.

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    masses = machine.known_masses
    body = lumped_platform(masses, machine.platform_points_m)
    z, f = ca.SX.sym("z", 11), ca.SX.sym("f", 6)
    centre = z[:3] + rotation_matrix(z[3], z[4], z[5]) @ ca.DM(body.centre_m)
    potential = -body.mass_kg * ca.dot(ca.DM(masses.gravity_mps2), centre)
    closure = closure_function(machine)(z[:6], z[6:])
    F_z = ca.densify(ca.jacobian(closure, z))
    curvature, _ = ca.hessian(potential + ca.dot(f, closure), z)
    balance = ca.solve(F_z[:, :6].T, -ca.densify(ca.gradient(potential, z))[:6])
    Z = ca.vertcat(ca.solve(F_z[:, :6], -F_z[:, 6:]), ca.SX.eye(5))
    K = Z.T @ ca.substitute(curvature, f, balance) @ Z
    return ca.Function("stiffness", [z[:6], z[6:]], [K], ["pose", "q"], ["K"])


def linearised_function(machine: Machine) -> ca.Function:
    """Build (pose, q, qd, qdd) -> dF/dq, dF/dqd of the forces of a motion, both (5, 5), in N/m and Ns/m.

    dF/dq follows the closures: the derivative by q, and that by the pose times d(pose)/dq. At qd = qdd = 0 it is
    `gravity_stiffness`; dF/dqdd is M.

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    of, qdd = _equations(machine), ca.SX.sym("qdd", 5)
    force = of.mass @ qdd + of.velocity + of.gravity
    by_q = ca.jacobian(force, of.q) + ca.jacobian(force, of.pose) @ of.pose_by_q
    by_qd = ca.jacobian(force, of.qd)
    return ca.Function(
        "linearised",
        [of.pose, of.q, of.qd, qdd],
        [ca.densify(by_q), ca.densify(by_qd)],
        ["pose", "q", "qd", "qdd"],
        ["by_q", "by_qd"],
    )


def _equations(machine: Machine) -> _Equations:
    masses = machine.known_masses
    body = lumped_platform(masses, machine.platform_points_m)
    pose, q, qd = ca.SX.sym("pose", 6), ca.SX.sym("q", 5), ca.SX.sym("qd", 5)
    z, v = ca.vertcat(pose, q), ca.SX.sym("v", 11)
    F_z, twice, _, _ = closure_terms_function(machine)(z, v, v)
    pose_by_q = ca.solve(F_z[:, :6], -F_z[:, 6:])
    rate = pose_by_q @ qd
    acceleration = ca.solve(F_z[:, :6], -ca.substitute(twice, v, ca.vertcat(rate, qd)))
    R, axes = rotation_matrix(pose[3], pose[4], pose[5]), rotation_axes(pose)
    centre, inertia = R @ ca.DM(body.centre_m), R @ ca.DM(body.inertia_kgm2) @ R.T
    weight = ca.DM(-body.mass_kg * masses.gravity_mps2)
    carts = ca.vertcat(ca.DM(cart_weights(machine, masses)), 0.0, 0.0)
    twist = ca.vertcat(pose_by_q[:3, :], axes @ pose_by_q[3:, :])
    omega = axes @ rate[3:]
    turning = axes @ acceleration[3:] + axes_rate(axes, pose, rate) @ rate[3:]
    skew = ca.skew(centre)
    upper = ca.horzcat(body.mass_kg * ca.SX.eye(3), -body.mass_kg * skew)
    M_p = ca.vertcat(upper, ca.horzcat(body.mass_kg * skew, inertia - body.mass_kg * skew @ skew))
    swing = body.mass_kg * ca.cross(omega, ca.cross(omega, centre))
    bias = ca.vertcat(swing, ca.cross(centre, swing) + ca.cross(omega, inertia @ omega))
    return _Equations(
        pose=pose,
        q=q,
        qd=qd,
        pose_by_q=pose_by_q,
        mass=twist.T @ M_p @ twist + ca.diag(ca.DM([*carried_cart_masses(masses), 0.0, 0.0])),
        velocity=twist.T @ (M_p @ ca.vertcat(acceleration[:3], turning) + bias),
        gravity=twist.T @ ca.vertcat(weight, ca.cross(centre, weight)) + carts,
    )
