"""How far the tool moves and turns with each drive alone, to first order, over intervals of a path."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.actuator_space import actuator_rates, amplification
from pipeline.refine.result import Path


@dataclass(frozen=True, eq=False)
class DriveAmplification:
    """The largest amplification of each drive over n intervals: computed at three values of s of each, not proven.

    Attributes
    ----------
    position : (n, 5)
        |dp / dq_k| in metres per metre.
    rotation_radpm : (n, 5)
        |omega| / |dq_k / dt| in radians per metre.
    """

    position: FloatArray
    rotation_radpm: FloatArray


def amplify_drives(path: Path, edges: FloatArray) -> DriveAmplification:
    """Compute the amplification of each drive at the ends and in the middle of intervals of s, edges (n + 1,).

    Raises
    ------
    ForwardKinematicsError
        Where the closure equations have no solution near the path's known poses.
    """
    middles = (edges[:-1] + edges[1:]) / 2.0
    s = np.append(np.column_stack([edges[:-1], middles]).ravel(), edges[-1])
    found = amplification(actuator_rates(path.machine, path.pose(s), path.q(s)[:, :3]))
    return DriveAmplification(_largest(found.position_by_drive), _largest(found.angle_by_drive))


def _largest(values: FloatArray) -> FloatArray:
    """Take the largest of three neighbouring rows, (2 n + 1, 5), of which intervals share one. Shape (n, 5)."""
    return np.asarray(np.maximum(np.maximum(values[:-2:2], values[1:-1:2]), values[2::2]))
