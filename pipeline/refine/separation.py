"""Clearance in the nonlinear program: which links have to be kept apart at which nodes, and by what.

Two segments are at least c apart exactly when a vector n with |n| <= 1 exists for which n . (a - b) >= c for
every end point a of the one and b of the other. With n as an unknown the condition is exact and smooth, also
for parallel links, whose closest points are not unique. A rail is an endless line along X: n has no x there.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.machine.clearance import link_distances, link_pairs, link_rail_distances, rail_pairs
from pipeline.machine.geometry import FloatArray, IntArray, Machine, cart_joints, link_vectors

_SAMPLES = 21


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
        A vector that separates them at the initial guess, or comes near to it.
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


def find_separations(machine: Machine, pose: FloatArray, q_m: FloatArray, margin_m: float, watch_m: float) -> Separations:
    """List the pairs nearer than `watch_m` at nodes with poses (k, 6) and actuators (k, 5)."""
    carts = q_m[:, :3]
    candidates = [(link_pairs(machine), link_distances(machine, pose, carts), machine.link_link_m, 0)]
    if np.isfinite(machine.link_rail_m):
        rails = link_rail_distances(machine, pose, carts)
        candidates.append((rail_pairs(machine), rails, machine.link_rail_m, 6))
    node, first, second, distance = [], [], [], []
    for pairs, distances, least, offset in candidates:
        rows, columns = np.nonzero(distances < watch_m)
        node.append(rows)
        first.append(np.array([a for a, _ in pairs])[columns])
        second.append(np.array([b for _, b in pairs])[columns] + offset)
        distance.append(np.full(len(rows), least + margin_m))
    node_, first_, second_ = np.concatenate(node), np.concatenate(first), np.concatenate(second)
    normal = _separating_vectors(machine, pose, carts, node_, first_, second_)
    return Separations(node_, first_, second_, normal, np.concatenate(distance))


def _separating_vectors(
    machine: Machine, pose: FloatArray, carts: FloatArray, node: IntArray, first: IntArray, second: IntArray
) -> FloatArray:
    """Unit vectors along the shortest connection of each pair, found on samples of both segments. Shape (m, 3)."""
    begin, vector = cart_joints(machine, carts), link_vectors(machine, pose, carts)
    part = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    a = begin[node, first][:, None] + part * vector[node, first][:, None]
    is_rail = second >= 6
    link, rail = np.where(is_rail, 0, second), np.where(is_rail, second - 6, 0)
    b = begin[node, link][:, None] + part * vector[node, link][:, None]
    on_rail = np.concatenate([a[:, :, :1], np.broadcast_to(machine.rails_m[rail][:, None], (*a.shape[:2], 2))], axis=2)
    b = np.where(is_rail[:, None, None], on_rail, b)
    apart = a[:, :, None] - b[:, None]
    if len(node) == 0:
        return np.empty((0, 3))
    nearest = np.argmin(np.linalg.norm(apart, axis=3).reshape(len(node), -1), axis=1)
    chosen = apart.reshape(len(node), -1, 3)[np.arange(len(node)), nearest]
    chosen[is_rail, 0] = 0.0
    unit: FloatArray = chosen / np.maximum(np.linalg.norm(chosen, axis=1, keepdims=True), 1e-12)
    return unit
