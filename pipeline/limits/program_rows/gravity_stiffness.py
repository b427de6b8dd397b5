"""Gravity stiffness in the nonlinear program: the pivots of K less its limit are positive.

An eigenvalue is not smooth where two of them meet, pivots are. They are taken in the eigenvectors V of K at the initial
guess, the largest eigenvalue first: there they are the eigenvalues less the limit, and it is the last one that fails.
"""

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from scipy.ndimage import binary_dilation

from pipeline.limits.interface.rows import Nodes, ProgramPart, Row
from pipeline.machine.actuator_space import actuator_rates, gravity_stiffness
from pipeline.machine.actuator_space.symbolic import stiffness_function
from pipeline.machine.geometry import ACTUATORS, Machine

if TYPE_CHECKING:
    from pipeline.limits.gravity_stiffness import GravityStiffness

_NEAR, _BESIDE = 0.9, 0.1
"""Nodes whose stiffness comes within this part of the scale get rows, and those beside them, up to this part of all:
stiffness changes steeply, and where rows end the path would go round them."""


def stiffness_part(limit: "GravityStiffness", margin: float, nodes: Nodes) -> ProgramPart:
    """Write that the pivots of (V' K V - (limit + margin) 1) / scale are not negative, at inner nodes near the limit.

    What is within the margin at the start or the goal, which are given, keeps what it has there.
    """
    values = limit.values(nodes.guess)[:, 0]
    near = binary_dilation(values < _NEAR, iterations=max(1, round(_BESIDE * len(values))))
    # Start and goal are given.
    rows = np.flatnonzero(near[1:-1]) + 1
    if len(rows) == 0:
        return ProgramPart(unknowns=(), rows=())
    kept = float(np.clip(values[[0, -1]].min(), 0.0, margin))
    guess, at = nodes.guess.take(rows), rows.tolist()
    K = gravity_stiffness(guess.machine, actuator_rates(guess.machine, guess.pose, guess.carts_m, guess.H))
    directions = np.linalg.eigh(K)[1][:, :, ::-1]
    pivots = _pivots_function(guess.machine, limit.least_npm, limit.scale_npm).map(len(rows))
    found = pivots(
        nodes.pose[:, at], nodes.q[:, at], ca.DM(directions.transpose(0, 2, 1).reshape(len(rows), 25).T), kept
    )
    return ProgramPart((), (Row(limit.wording.name, ca.vec(found), 0.0, np.inf),))


def _pivots_function(machine: Machine, least_npm: float, scale_npm: float) -> ca.Function:
    """Build (pose, q, V by columns, margin) -> the pivots of (V' K V - least 1) / scale - margin 1, (5,)."""
    count = len(ACTUATORS)
    pose, q, columns, margin = ca.SX.sym("pose", 6), ca.SX.sym("q", 5), ca.SX.sym("V", count**2), ca.SX.sym("margin")
    V = ca.reshape(columns, count, count)
    K = stiffness_function(machine)(pose, q)
    A = (V.T @ K @ V - least_npm * ca.SX.eye(count)) / scale_npm - margin * ca.SX.eye(count)
    pivots = []
    for _ in range(count):
        pivot, beside = A[0, 0], A[1:, 0]
        pivots.append(pivot)
        A = A[1:, 1:] - beside @ beside.T / pivot
    return ca.Function("pivots", [pose, q, columns, margin], [ca.vertcat(*pivots)])
