"""What no correction can do: where an arm changes its working mode, planned poses miss the boundary of its reach.

Arm k changes its mode where D_k = L^2 - a^2 = 0, with a the distance of its platform joint from its rail: where the
joint is at the distance L from the rail. If the planned poses pass that place at a distance L - g of the calibrated
machine, the platform has to deviate by g, of whichever sign, to be able to change the mode: outwards where they do not
come far enough (g > 0), inwards where they are out of reach (g < 0). Turning it by a little may take a part of g.
"""

from typing import NamedTuple

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import PRIMARY, Machine
from pipeline.machine.kinematics import discriminants
from pipeline.machine.working_modes import reach_along_rails
from pipeline.refine.result import Path

_NEAR_M = 0.2
"""How far a cart is from its platform joint, along the rail, near a change of its mode."""


class ReachGap(NamedTuple):
    """A change of mode: the arm (1, 2, 3), where, and by how much the planned poses miss it."""

    arm: int
    s: float
    gap_m: float


def reach_gaps(planned: Path, machine: Machine, s: FloatArray, reached: FloatArray) -> list[ReachGap]:
    """Find by how much planned poses at s (n,) miss the changes of mode of a machine, which reaches poses (n, 6)."""
    pose = planned.pose(s)
    sides = reach_along_rails(planned.machine, pose, planned.q(s)[:, :3])
    # ry follows from the rest, on the machine as it is.
    pose[:, 4] = reached[:, 4]
    lengths = machine.lengths_m[PRIMARY]
    gaps = lengths - np.sqrt(lengths**2 - discriminants(machine, pose))
    found = []
    for arm in range(3):
        for change in np.flatnonzero(np.diff(np.sign(sides[:, arm])) != 0.0):
            far = np.flatnonzero(np.abs(sides[:, arm]) > _NEAR_M)
            first = far[far < change].max(initial=-1) + 1
            last = far[far > change].min(initial=len(s))
            row = int(first + np.argmin(gaps[first:last, arm]))
            found.append(ReachGap(arm + 1, float(s[row]), float(gaps[row, arm])))
    return sorted(set(found), key=lambda one: one.s)
