"""Two reflectors on the platform: where they are in its frame, and so in space."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import rotation


@dataclass(frozen=True, eq=False)
class Reflectors:
    """Where the reflectors are on the platform, and how well a tracker sees them.

    The vector from the first to the second is best along the platform's y axis: then ry does not enter rx and rz at
    all, and both are known equally well. It must not be parallel to the platform's x or z axis (the paper, section 5).

    Attributes
    ----------
    points_m : (2, 3)
        Both reflectors in the platform frame, from the TCP.
    noise_m : float
        Standard deviation of every measured coordinate; independent, zero mean.
    """

    points_m: FloatArray
    noise_m: float


def reflector_positions(points_m: FloatArray, pose: FloatArray) -> FloatArray:
    """P + R r_i of reflectors r_i (2, 3) for poses (n, 6). Shape (n, 2, 3)."""
    R = rotation(pose[:, 3], pose[:, 4], pose[:, 5])
    positions: FloatArray = pose[:, None, :3] + points_m @ np.swapaxes(R, 1, 2)
    return positions
