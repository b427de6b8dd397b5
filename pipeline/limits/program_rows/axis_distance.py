"""Distances between axes in the nonlinear program, kept by separating vectors.

Two segments are at least c apart exactly if a vector n with |n| <= 1 exists for which n . (a - b) >= c for every end
point a of the one and b of the other. With n as an unknown the condition is exact and smooth, also for parallel links,
whose closest points are not unique. A rail is an endless line: n has no x there, and its part across the rail counts,
which is n itself on parallel rails.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.limits.interface.rows import Nodes, ProgramPart, Row, Unknowns
from pipeline.machine.clearance import common_perpendicular
from pipeline.machine.geometry import Machine, cart_joints, dot, link_vectors
from pipeline.machine.rails import rail_origins
from pipeline.machine.samples import PoseSamples
from pipeline.machine.symbolic import joints_function

_LINKS = 6


@dataclass(frozen=True, eq=False)
class Separations:
    """Pairs kept apart, one row per node and pair.

    Attributes
    ----------
    nodes : (m,)
        Collocation node.
    first, second : (m,)
        A link 0 to 5; the other link 0 to 5, or the rail 0 to 2.
    from_rail : bool
        Whether the second of every pair is a rail.
    normal : (m, 3)
        Unit vectors that separate the pairs best at the initial guess.
    least_m : float
        Least distance asked for.
    """

    nodes: IntArray
    first: IntArray
    second: IntArray
    from_rail: bool
    normal: FloatArray
    least_m: float

    def __len__(self) -> int:
        return len(self.nodes)


def separation_part(
    name: str, pairs: list[tuple[int, int]], from_rail: bool, distances_m: FloatArray, least_m: float, nodes: Nodes
) -> ProgramPart:
    """Write the rows of all pairs that come near at the guess, and their separating vectors.

    Parameters
    ----------
    distances_m : (k, pairs)
        Distances at the guess. The first and the last node are left out: they are given, and may be nearer than the
        margin allows.
    """
    found = find_separations(pairs, from_rail, distances_m, least_m, nodes)
    normal = ca.MX.sym("n", 3, len(found))
    bound = np.full((len(found), 3), np.inf)
    if from_rail:
        bound[:, 0] = 0.0
    apart = apartness(nodes.guess.machine, found, nodes.pose, nodes.q, normal)
    return ProgramPart(
        unknowns=(Unknowns(normal, found.normal, -bound, bound),),
        rows=(
            Row(name, apart, 0.0, np.inf),
            Row(f"separating vectors ({name})", ca.vec(ca.sum1(normal**2)), -np.inf, 1.0),
        ),
    )


def find_separations(
    pairs: list[tuple[int, int]], from_rail: bool, distances_m: FloatArray, least_m: float, nodes: Nodes
) -> Separations:
    """List the pairs that are less than the reach above their least distance at inner nodes."""
    rows, columns = np.nonzero(distances_m[1:-1] < least_m + nodes.reach_m)
    first = np.array([a for a, _ in pairs])[columns]
    second = np.array([b for _, b in pairs])[columns]
    normal = _separating_vectors(nodes.guess, rows + 1, first, second, from_rail)
    return Separations(rows + 1, first, second, from_rail, normal, least_m + nodes.clearance_margin_m)


def _separating_vectors(
    samples: PoseSamples, nodes: IntArray, first: IntArray, second: IntArray, from_rail: bool
) -> FloatArray:
    """Compute unit vectors along the shortest connection of each pair. Shape (m, 3)."""
    machine, carts = samples.machine, samples.carts_m
    begin, vector = cart_joints(machine, carts), link_vectors(machine, samples.pose, carts)
    p, u = begin[nodes, first], vector[nodes, first]
    if from_rail:
        # Of the rail only the part abreast of the link matters.
        origin, along = rail_origins(machine)[second], machine.rail_directions[second]
        q, v = origin + dot(p - origin, along)[:, None] * along, dot(u, along)[:, None] * along
    else:
        q, v = begin[nodes, second], vector[nodes, second]
    connection = shortest_connection(p, u, q, v)
    if from_rail:
        connection[:, 0] = 0.0
    length = np.linalg.norm(connection, axis=1, keepdims=True)
    return np.asarray(connection / np.maximum(length, 1e-12), dtype=float)


def shortest_connection(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
    """Return the vector from the segment q + [0, 1] v to p + [0, 1] u where they are nearest. Shapes (n, 3).

    Either the common perpendicular meets both segments, or an end point of one of them is nearest.
    """
    _, s, t = common_perpendicular(p, u, q, v)
    inside = (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    zero, one = np.zeros(len(p)), np.ones(len(p))
    on_first = np.stack([zero, one, _foot(q, p, u), _foot(q + v, p, u), np.where(inside, s, 0.0)])
    on_second = np.stack([_foot(p, q, v), _foot(p + u, q, v), zero, one, np.where(inside, t, 0.0)])
    connections = p + on_first[..., None] * u - q - on_second[..., None] * v
    nearest = np.argmin(np.linalg.norm(connections, axis=2), axis=0)
    return np.asarray(connections[nearest, np.arange(len(p))], dtype=float)


def _foot(point: FloatArray, begin: FloatArray, vector: FloatArray) -> FloatArray:
    """Find where on the segment begin + [0, 1] vector the point is nearest. Shape (n,)."""
    squared = np.sum(vector**2, axis=1)
    along = np.sum((point - begin) * vector, axis=1)
    return np.asarray(np.clip(along / np.where(squared > 0.0, squared, 1.0), 0.0, 1.0), dtype=float)


def apartness(machine: Machine, separations: Separations, pose: ca.MX, q: ca.MX, normal: ca.MX) -> ca.MX:
    """Write n . (a - b) - c for the end points a of the first and b of the second of every pair: to be >= 0.

    For poses (6, k), actuators (5, k) and vectors (3, m). Four entries for two links; two for a link and a rail,
    of which any one point will do. Shape (entries,).
    """
    if len(separations) == 0:
        return ca.MX(0, 1)
    nodes = pose.shape[1]
    platform, cart = joints_function(machine).map(nodes)(pose, q)
    points = ca.vertcat(ca.vec(platform), ca.vec(cart))
    axis = np.arange(3)

    def joint(kind: int, link: IntArray) -> ca.MX:
        """Platform (0) or cart (1) joints of links, as columns: where CasADi's order puts them."""
        at = 18 * (kind * nodes + separations.nodes) + link
        return _columns(points, at[:, None] + _LINKS * axis)

    others: list[ca.MX | ca.DM]
    if separations.from_rail:
        others = [ca.DM(rail_origins(machine)[separations.second].T)]
        if not machine.has_parallel_rails:
            along = ca.DM(machine.rail_directions[separations.second].T)
            normal = normal - along * ca.repmat(ca.sum1(normal * along), 3, 1)
    else:
        others = [joint(kind, separations.second) for kind in (0, 1)]
    entries = []
    for a in (joint(kind, separations.first) for kind in (0, 1)):
        entries += [ca.vec(ca.sum1(normal * (a - b)) - separations.least_m) for b in others]
    return ca.vertcat(*entries)


def _columns(points: ca.MX, index: IntArray) -> ca.MX:
    """Gather entries (m, 3) of a vector as the columns of a matrix (3, m)."""
    return ca.reshape(points[index.ravel().tolist()], 3, len(index))
