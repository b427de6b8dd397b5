"""Working modes seen on a moving machine: on which side of its platform joint every cart joint is."""

from collections.abc import Sequence

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import ARM_OF_LINK, PRIMARY, Machine, link_vectors
from pipeline.machine.rails import along_rails

_AT_GATE_M = 1e-6
"""An arm this close to its serial singularity is in neither mode: rounding would decide."""


def reach_along_rails(machine: Machine, pose: FloatArray, carts_m: FloatArray) -> FloatArray:
    """By how much the cart joint of every arm is farther along its rail than its platform joint, in metres.

    (C - A) . d of its primary link: C_x - A_x on parallel rails.

    Positive in mode R, negative in mode L, zero at the arm's serial singularity. Shape (n, 3).
    """
    vectors = link_vectors(machine, pose, carts_m)[:, PRIMARY]
    reach: FloatArray = -along_rails(machine, vectors, ARM_OF_LINK[PRIMARY])
    return reach


def working_modes(reach_m: FloatArray) -> FloatArray:
    """Tell the mode of each arm along a motion from its reach (n, 3): -1 (L) or +1 (R). Shape (n, 3).

    At a gate the arm keeps the mode it comes from.
    """
    decided = np.abs(reach_m) > _AT_GATE_M
    rows = np.where(decided, np.arange(len(reach_m))[:, None], np.argmax(decided, axis=0))
    last_decided = np.maximum.accumulate(rows, axis=0)
    return np.where(np.take_along_axis(reach_m, last_decided, axis=0) < 0.0, -1.0, 1.0)


def mode_names(modes: FloatArray) -> list[str]:
    """Name working modes (n, 3) as given by `working_modes`: LLL to RRR, arm 1 first."""
    return ["".join("L" if sign < 0.0 else "R" for sign in row) for row in modes]


def mode_sequence(modes: FloatArray) -> Sequence[str]:
    """Name the working modes (n, 3) in the order in which they are gone through, each once."""
    names = mode_names(modes)
    return [name for row, name in enumerate(names) if row == 0 or name != names[row - 1]]
