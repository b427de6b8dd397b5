"""Rows that the programs of stage two share: closure, splines, sides of the carts, straight ends, directions."""

from collections.abc import Sequence

import casadi as ca
import numpy as np
from scipy.linalg import null_space
from scipy.sparse import csr_array

from pipeline.arrays import FloatArray
from pipeline.limits.interface.rows import Row
from pipeline.machine.geometry import LINKS, PRIMARY, Machine
from pipeline.machine.symbolic import closure_function, joints_function
from pipeline.refine.corridor.cells import Corridor
from pipeline.refine.corridor.cone import Walls
from pipeline.refine.mesh import Mesh
from pipeline.refine.one_way import OneWayLeg
from pipeline.refine.splines import basis


def node_rows(machine: Machine, mesh: Mesh, pose: ca.MX, q: ca.MX, coefficients: ca.MX) -> list[Row]:
    """Write that the links of every node close, pose (6, k) and q (5, k), and that q is on the splines (5, n)."""
    return [
        Row("closure", ca.vec(closure_function(machine).map(len(mesh.s))(pose, q)), 0.0, 0.0),
        Row("spline", ca.vec(q - coefficients @ sparse(basis(mesh.knots, mesh.s)).T), 0.0, 0.0),
    ]


def side_rows(machine: Machine, corridor: Corridor, pose: ca.MX, q: ca.MX) -> list[Row]:
    """Write side * (C - A) . d for the arms and nodes that have a side; pose (6, k), q (5, k)."""
    nodes, arms = np.nonzero(corridor.sides)
    if len(nodes) == 0:
        return []
    platform, cart = (ca.vec(joints) for joints in joints_function(machine).map(pose.shape[1])(pose, q))
    # Every node has 18 entries by columns, x first.
    rows = 18 * nodes + PRIMARY[arms]
    beyond = ca.MX(0.0)
    for axis, along in enumerate(machine.rail_directions[arms].T):
        if along.any():
            at = (rows + len(LINKS) * axis).tolist()
            beyond += ca.DM(along) * (cart[at] - platform[at])
    reach = ca.DM(corridor.sides[nodes, arms]) * beyond
    return [Row("sides of the carts", reach, corridor.side_margin_m, np.inf)]


def wall_rows(walls: Walls, pose: ca.MX) -> list[Row]:
    """Write that the TCP of nodes is behind walls: normal . (x, y, z) - offset <= 0; pose (6, k)."""
    if len(walls) == 0:
        return []
    distance = ca.sum1(ca.DM(walls.normal.T) * pose[:3, walls.node.tolist()]).T - ca.DM(walls.offset)
    return [Row("cones of straight ends", distance, -np.inf, 0.0)]


def direction_rows(directions: FloatArray, legs: tuple[ca.MX, ca.MX]) -> list[Row]:
    """Write that a leg of the control polygon has nothing across its direction, and something along it.

    `directions` (2, 5) are those at start and goal, NaN where they are free; `legs` two of (5, 1).
    """
    rows = []
    for name, direction, leg in zip(("start", "goal"), directions, legs, strict=True):
        if np.isfinite(direction).all():
            across = null_space(direction[None]).T
            rows.append(Row(f"direction at the {name}", ca.DM(across) @ leg, 0.0, 0.0))
            rows.append(Row(f"sense of direction at the {name}", ca.dot(ca.DM(direction), leg), 0.0, np.inf))
    return rows


def one_way_rows(legs: Sequence[OneWayLeg], coefficients: ca.MX) -> list[Row]:
    """Write that legs of the control polygon do not go the way that is blocked to their actuators."""
    if not legs:
        return []
    rows = [-sign * (coefficients[axis, leg + 1] - coefficients[axis, leg]) for leg, axis, sign in legs]
    return [Row("ways blocked at the ends", ca.vertcat(*rows), 0.0, np.inf)]


def sparse(matrix: csr_array) -> ca.DM:
    """Convert a sparse matrix for CasADi."""
    triplets = matrix.tocoo()
    return ca.DM.triplet(triplets.row.tolist(), triplets.col.tolist(), ca.DM(triplets.data), *matrix.shape)
