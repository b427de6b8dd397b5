"""Points between which a machine is drawn: ends of its rails, carts, joints, and the bars of its platform."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine.geometry import Machine, cart_joints, platform_arms
from pipeline.machine.rails import rail_points


@dataclass(frozen=True, eq=False)
class DrawnPoints:
    """What moves of a machine, at poses (...).

    Attributes
    ----------
    feet_m : (..., 3, 3)
        Carts on their rails.
    cart_joints_m, platform_joints_m : (..., 6, 3)
        Both ends C_l, A_l of every link.
    """

    feet_m: FloatArray
    cart_joints_m: FloatArray
    platform_joints_m: FloatArray


def drawn_points(machine: Machine, pose: FloatArray, q_m: FloatArray) -> DrawnPoints:
    """Compute what is drawn at poses (..., 6) with actuators (..., 5), in metres."""
    carts = q_m[..., :3]
    return DrawnPoints(
        feet_m=rail_points(machine, carts),
        cart_joints_m=cart_joints(machine, carts),
        platform_joints_m=pose[..., None, :3] + platform_arms(machine, pose),
    )


def rail_ends(machine: Machine) -> FloatArray:
    """Compute both ends of each rail in metres, shape (3, 2, 3)."""
    return np.stack([rail_points(machine, end) for end in machine.travel_m.T], axis=1)


def platform_corners(machine: Machine) -> FloatArray:
    """Return the TCP and the platform's joints in its own frame, in metres, shape (7, 3)."""
    return np.vstack([np.zeros(3), machine.platform_points_m])


def platform_bars(machine: Machine) -> IntArray:
    """Join `platform_corners` by the shortest bars that hold them together, where no body of the platform is known.

    A minimum spanning tree (Kruskal, 1956): unlike a hull, it leaves room for links to sweep between joints. Pairs of
    corners, shape (6, 2).
    """
    corners = platform_corners(machine)
    pairs = np.array(list(combinations(range(len(corners)), 2)))
    lengths = np.linalg.norm(corners[pairs[:, 0]] - corners[pairs[:, 1]], axis=1)
    group = np.arange(len(corners))
    bars = []
    for one, other in pairs[np.argsort(lengths.round(9), kind="stable")]:
        if group[one] != group[other]:
            bars.append((one, other))
            group[group == group[other]] = group[one]
    return np.array(bars)
