"""Cones of joints in the nonlinear program: the link's vector along the axis is at least its length times a cosine.

Multiplied by the length it is a polynomial in the vector, and needs no root: telescopes have theirs among the unknowns.
"""

import casadi as ca
import numpy as np

from pipeline.arrays import FloatArray
from pipeline.limits.interface.rows import Nodes, ProgramPart, Row
from pipeline.machine.geometry import TELESCOPES, Machine
from pipeline.machine.joints.cone import JointCone
from pipeline.machine.symbolic import joints_function, rotation_matrix

_NEAR = 0.2
"""A joint gets rows if its cosine comes as near as this to the edge of its cone, at all nodes: it may come near at
others, too, and rows are few."""
_ENDS = 0.1
"""Part of the nodes over which the margin grows from what start and goal, which are given, have of it."""


def cone_part(name: str, cone: JointCone, values: FloatArray, margin: float, nodes: Nodes) -> ProgramPart:
    """Write along . axis - (cos(half angle) + margin) length >= 0 at inner nodes, per usual length of the link.

    `values` (k,) are cosines at the guess less that of the half angle.
    """
    if len(values) < 3 or values.min() > _NEAR:
        return ProgramPart((), ())
    least = cone.least_cosine + _kept(values, margin)[1:-1]
    rows = cone_function(nodes.guess.machine, cone).map(len(least))
    found = rows(nodes.pose[:, 1:-1], nodes.q[:, 1:-1], ca.DM(least).T)
    return ProgramPart((), (Row(name, ca.vec(found), 0.0, np.inf),))


def _kept(values: FloatArray, margin: float) -> FloatArray:
    """Choose the margin of every node (k,): near a start or goal that is within it, less."""
    at_start, at_goal = np.clip(values[[0, -1]], 0.0, margin)
    along = np.linspace(0.0, 1.0, len(values)) / _ENDS * margin
    return np.asarray(np.minimum(margin, np.minimum(at_start + along, at_goal + along[::-1])), dtype=float)


def cone_function(machine: Machine, cone: JointCone) -> ca.Function:
    """Build (pose, q, least cosine) -> (along . axis - cosine length) / usual length, with `along` as it leaves."""
    pose, q, cosine = ca.SX.sym("pose", 6), ca.SX.sym("q", 5), ca.SX.sym("cosine")
    platform, cart = joints_function(machine)(pose, q)
    vector, axis = (platform[cone.link, :] - cart[cone.link, :]).T, ca.DM(cone.axis)
    if cone.at_platform:
        along = -ca.dot(rotation_matrix(pose[3], pose[4], pose[5]) @ axis, vector)
    else:
        along = ca.dot(axis, vector)
    usual, length = machine.lengths_m.copy(), ca.SX(machine.lengths_m)
    usual[TELESCOPES], length[TELESCOPES] = machine.strokes_m.mean(axis=1), q[3:]
    row = (along - cosine * length[cone.link]) / float(usual[cone.link])
    return ca.Function("cone", [pose, q, cosine], [row])
