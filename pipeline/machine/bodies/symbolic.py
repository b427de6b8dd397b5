"""The points of hulls as CasADi functions, for gradient-based optimisation."""

import casadi as ca

from pipeline.machine.geometry import Machine
from pipeline.machine.rails import rail_origins
from pipeline.machine.shapes.model import FrameKind, SweptHull
from pipeline.machine.symbolic import joints_function, rotation_matrix


def hull_function(machine: Machine, hull: SweptHull) -> ca.Function:
    """Build (pose, q) -> the points of a hull (k, 3), as `placement.Frames.points`."""
    pose, q = ca.SX.sym("pose", 6), ca.SX.sym("q", 5)
    given = hull.points_m
    if hull.kind == FrameKind.PLATFORM:
        R = rotation_matrix(pose[3], pose[4], pose[5])
        points = ca.repmat(pose[:3].T, len(given), 1) + ca.DM(given) @ R.T
    elif hull.kind == FrameKind.LINK:
        platform, cart = (joints[hull.number, :] for joints in joints_function(machine)(pose, q))
        vector = platform - cart
        share = ca.DM(given[:, 0]) + ca.DM(given[:, 1]) / ca.norm_2(vector)
        points = ca.repmat(cart, len(given), 1) + share @ vector
    elif hull.kind == FrameKind.CART:
        fixed = given + rail_origins(machine)[hull.number]
        along = ca.sparsify(ca.DM(machine.rail_directions[hull.number][None]))
        points = ca.DM(fixed) + ca.repmat(q[hull.number] * along, len(given), 1)
    else:
        points = ca.SX(ca.DM(given))
    return ca.Function("hull", [pose, q], [ca.densify(points)], ["pose", "q"], ["points"])
