"""Forces along the links of a machine that was simulated, from how it moves."""

import casadi as ca
import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.dynamics import Forces, inverse_dynamics
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import pose_jacobian
from pipeline.machine.symbolic import closure_terms_function


def forces_of(machine: Machine, pose: FloatArray, q_m: FloatArray, qd_mps: FloatArray, qdd_mps2: FloatArray) -> Forces:
    """Compute the forces that a motion in actuator space takes, without friction and the drives' own mass.

    With z = (pose, q), v = z' and the closures F(z) = 0, the pose's second derivative solves F_pose pose'' =
    -(F_q qdd + F_zz[v, v]).

    Parameters
    ----------
    pose, q_m, qd_mps, qdd_mps2 : (n, 6), (n, 5), (n, 5), (n, 5)
        Poses, actuators, their velocities and accelerations.

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    rate = np.einsum("nij,nj->ni", pose_jacobian(machine, pose, q_m), qd_mps)
    z, v = np.hstack([pose, q_m]), np.hstack([rate, qd_mps])
    first, twice = _closure_function(machine).map(len(z))(z.T, v.T)
    by_z = np.asarray(first, dtype=float).reshape(6, len(z), 11).transpose(1, 0, 2)
    right = np.einsum("nij,nj->ni", by_z[:, :, 6:], qdd_mps2) + np.asarray(twice, dtype=float).T
    acceleration = np.linalg.solve(by_z[:, :, :6], -right[..., None])[..., 0]
    return inverse_dynamics(machine, machine.known_masses, pose, q_m[:, :3], rate, acceleration, qdd_mps2[:, :3])


def _closure_function(machine: Machine) -> ca.Function:
    """Build (z, v) -> F_z, F_zz[v, v], without the terms that are not asked for."""
    z, v = ca.SX.sym("z", 11), ca.SX.sym("v", 11)
    first, twice, _, _ = closure_terms_function(machine)(z, v, v)
    return ca.Function("closure", [z, v], [first, twice], {"cse": True})
