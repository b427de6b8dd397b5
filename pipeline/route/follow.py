"""Moves followed continuously: what lies between two neighbouring regions.

A move is the straight line in actuator space between two regions. It is good when the machine, marched along
it by forward kinematics, arrives at the pose of the second region with the sign of det H, the kappa cap, the
clearance and the tilt limit kept all the way. Travel and strokes hold between when they hold at both ends.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from pipeline.config import Config
from pipeline.machine.clearance import min_distances
from pipeline.machine.geometry import BoolArray, FloatArray, Machine
from pipeline.machine.kinematics import follow
from pipeline.machine.statics import condition_number, det_sign, statics_matrix

_ARRIVAL = 1e-6
"""How far, in metres and radians, the marched pose may end from the region's: rounding, or another branch."""
_TILTS = [3, 5]


class Flaw(StrEnum):
    """Why a move is not admissible when followed continuously."""

    LOST = "the closure equations lose their solution"
    ELSEWHERE = "it ends on another branch of the forward kinematics"
    SINGULAR = "det H changes sign"
    KAPPA = "kappa exceeds its cap"
    LINKS = "links come too close"
    RAILS = "a link comes too close to a rail"
    TILT = "the platform tilts too far"


@dataclass(frozen=True, eq=False)
class MoveChecks:
    """What following moves (n,) showed; `flaw` holds the first of the reasons that applies, None for none."""

    flaw: list[Flaw | None]
    kappa_max: FloatArray

    @property
    def good(self) -> BoolArray:
        """Which moves are admissible, shape (n,)."""
        return np.array([flaw is None for flaw in self.flaw], dtype=bool)


def check_moves(config: Config, machine: Machine, pose: FloatArray, q_m: FloatArray) -> MoveChecks:
    """Follow moves given by their two ends: poses (n, 2, 6) and actuator positions (n, 2, 5)."""
    samples = config.route.follow.samples
    part = np.linspace(0.0, 1.0, samples + 1)[:, None]
    q = q_m[:, :1] * (1.0 - part) + q_m[:, 1:] * part
    marched, misses = follow(machine, q, pose[:, 0])
    n, m = q.shape[:2]
    H = statics_matrix(machine, marched, q[..., :3])
    kappa = condition_number(H).max(axis=1)
    links, rails = min_distances(machine, marched.reshape(-1, 6), q[..., :3].reshape(-1, 3))
    signs = det_sign(H)
    tilt = np.abs(marched[..., _TILTS]).max(axis=(1, 2))
    tilt_limit = np.deg2rad(config.task.tilt_max_deg + config.route.follow.tilt_overshoot_deg)
    findings = [
        (Flaw.LOST, ~np.isfinite(misses).all(axis=1)),
        (Flaw.ELSEWHERE, np.abs(marched[:, -1] - pose[:, 1]).max(axis=1) > _ARRIVAL),
        (Flaw.SINGULAR, (signs != signs[:, :1]).any(axis=1)),
        (Flaw.KAPPA, kappa > config.route.kappa_max),
        (Flaw.LINKS, links.reshape(n, m).min(axis=1) < machine.link_link_m),
        (Flaw.RAILS, rails.reshape(n, m).min(axis=1) < machine.link_rail_m),
        (Flaw.TILT, tilt > tilt_limit),
    ]
    flaws: list[Flaw | None] = [None] * n
    for flaw, found in reversed(findings):
        for row in np.flatnonzero(found):
            flaws[row] = flaw
    return MoveChecks(flaws, kappa)
