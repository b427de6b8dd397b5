"""Clearance in the nonlinear program: which links have to be kept apart at which nodes, and by what.

Two segments are at least c apart exactly when a vector n with |n| <= 1 exists for which n . (a - b) >= c for
every end point a of the one and b of the other. With n as an unknown the condition is exact and smooth, also
for parallel links, whose closest points are not unique. A rail is an endless line along X: n has no x there.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.machine.clearance import (
    common_perpendicular,
    link_distances,
    link_pairs,
    link_rail_distances,
    rail_pairs,
)
from pipeline.machine.geometry import Machine, cart_joints, link_vectors
from pipeline.machine.symbolic import joints_function

_LINKS = 6


@dataclass(frozen=True, eq=False)
class Separations:
    """Pairs kept apart, one row per node and pair.

    Attributes
    ----------
    node : (m,)
        Collocation node.
    first : (m,)
        Link 0 to 5.
    second : (m,)
        The other link 0 to 5, or 6 plus the rail.
    normal : (m, 3)
        The unit vector that separates them best at the initial guess.
    distance_m : (m,)
        Least distance asked for.
    """

    node: IntArray
    first: IntArray
    second: IntArray
    normal: FloatArray
    distance_m: FloatArray

    def __len__(self) -> int:
        return len(self.node)

    @property
    def of_rail(self) -> BoolArray:
        """Which rows keep a link from a rail, shape (m,)."""
        return self.second >= _LINKS


def find_separations(
    machine: Machine, pose: FloatArray, q_m: FloatArray, margin_m: float, reach_m: float
) -> Separations:
    """List the pairs less than `reach_m` above their clearance at nodes with poses (k, 6) and actuators (k, 5).

    The first and the last node are left out: they are given, and may be nearer to the clearance than the margin.
    """
    carts = q_m[:, :3]
    candidates = [(link_pairs(machine), link_distances(machine, pose, carts), machine.link_link_m, 0)]
    if np.isfinite(machine.link_rail_m):
        rails = link_rail_distances(machine, pose, carts)
        candidates.append((rail_pairs(machine), rails, machine.link_rail_m, _LINKS))
    node, first, second, distance = [], [], [], []
    for pairs, distances, least, offset in candidates:
        rows, columns = np.nonzero(distances[1:-1] < least + reach_m)
        node.append(rows + 1)
        first.append(np.array([a for a, _ in pairs])[columns])
        second.append(np.array([b for _, b in pairs])[columns] + offset)
        distance.append(np.full(len(rows), least + margin_m))
    node_, first_, second_ = np.concatenate(node), np.concatenate(first), np.concatenate(second)
    normal = _separating_vectors(machine, pose, carts, node_, first_, second_)
    return Separations(node_, first_, second_, normal, np.concatenate(distance))


def _separating_vectors(
    machine: Machine, pose: FloatArray, carts: FloatArray, node: IntArray, first: IntArray, second: IntArray
) -> FloatArray:
    """Unit vectors along the shortest connection of each pair. Shape (m, 3)."""
    begin, vector = cart_joints(machine, carts), link_vectors(machine, pose, carts)
    p, u = begin[node, first], vector[node, first]
    is_rail = second >= _LINKS
    link = np.where(is_rail, 0, second)
    q, v = begin[node, link], vector[node, link]
    # Of the rail only the part abreast of the link matters.
    q[is_rail, 0], v[is_rail, 0] = p[is_rail, 0], u[is_rail, 0]
    q[is_rail, 1:], v[is_rail, 1:] = machine.rails_m[second[is_rail] - _LINKS], 0.0
    connection = shortest_connection(p, u, q, v)
    connection[is_rail, 0] = 0.0
    unit: FloatArray = connection / np.maximum(np.linalg.norm(connection, axis=1, keepdims=True), 1e-12)
    return unit


def shortest_connection(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
    """Vector from the segment q + [0, 1] v to the segment p + [0, 1] u where they are nearest. Shapes (n, 3).

    Either the common perpendicular meets both segments, or an end point of one of them is nearest.
    """
    _, s, t = common_perpendicular(p, u, q, v)
    inside = (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    zero, one = np.zeros(len(p)), np.ones(len(p))
    on_first = np.stack([zero, one, _foot(q, p, u), _foot(q + v, p, u), np.where(inside, s, 0.0)])
    on_second = np.stack([_foot(p, q, v), _foot(p + u, q, v), zero, one, np.where(inside, t, 0.0)])
    connections = p + on_first[..., None] * u - q - on_second[..., None] * v
    nearest = np.argmin(np.linalg.norm(connections, axis=2), axis=0)
    chosen: FloatArray = connections[nearest, np.arange(len(p))]
    return chosen


def _foot(point: FloatArray, begin: FloatArray, vector: FloatArray) -> FloatArray:
    """Where on the segment begin + [0, 1] vector the point is nearest. Shape (n,)."""
    squared = np.sum(vector**2, axis=1)
    along = np.sum((point - begin) * vector, axis=1)
    foot: FloatArray = np.clip(along / np.where(squared > 0.0, squared, 1.0), 0.0, 1.0)
    return foot


def apartness(machine: Machine, separations: Separations, pose: ca.MX, q: ca.MX, normal: ca.MX) -> ca.MX:
    """Write n . (a - b) - c for the end points a of the first and b of the second of every pair: to be >= 0.

    For poses (6, k), actuators (5, k) and vectors (3, m). Four entries for two links; two for a link and a rail,
    of which any one point will do. Shape (entries,).
    """
    nodes = pose.shape[1]
    platform, cart = joints_function(machine).map(nodes)(pose, q)
    rails = np.column_stack([np.zeros(len(machine.rails_m)), machine.rails_m])
    points = ca.vertcat(ca.vec(platform), ca.vec(cart), ca.DM(rails.ravel()))
    axis = np.arange(3)

    def joint(kind: int, link: IntArray, rows: IntArray) -> ca.MX:
        """Platform (0) or cart (1) joints of links, as columns: where CasADi's order puts them."""
        at = 18 * (kind * nodes + separations.node[rows]) + link[rows]
        return _columns(points, at[:, None] + _LINKS * axis)

    entries = []
    for rows in (np.flatnonzero(~separations.of_rail), np.flatnonzero(separations.of_rail)):
        if len(rows) == 0:
            continue
        if separations.of_rail[rows[0]]:
            rail = separations.second[rows] - _LINKS
            others = [_columns(points, 36 * nodes + 3 * rail[:, None] + axis)]
        else:
            others = [joint(kind, separations.second, rows) for kind in (0, 1)]
        n, least = normal[:, rows.tolist()], ca.DM(separations.distance_m[rows]).T
        for a in (joint(kind, separations.first, rows) for kind in (0, 1)):
            entries += [ca.vec(ca.sum1(n * (a - b)) - least) for b in others]
    return ca.vertcat(*entries)


def _columns(points: ca.MX, index: IntArray) -> ca.MX:
    """Gather entries (m, 3) of a vector as the columns of a matrix (3, m)."""
    return ca.reshape(points[index.ravel().tolist()], 3, len(index))
