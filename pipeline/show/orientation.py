"""Orientations as quaternions (w, x, y, z), and the tilts in them."""

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import rotation, rotation_x, rotation_z


def pose_quaternion(pose: FloatArray) -> FloatArray:
    """Give the orientation of the platform at a pose (6,)."""
    return _quaternion(rotation(*pose[3:]))


def tilt_quaternion(pose: FloatArray) -> FloatArray:
    """Give Rx(rx) Rz(rz) of a pose (6,): the tilt without the dependent angle."""
    return _quaternion(rotation_x(pose[3]) @ rotation_z(pose[5]))


def tilts_of(wxyz: FloatArray) -> tuple[float, float]:
    """Read rx and rz of R = Rx(rx) Rz(rz) Ry(ry), whatever ry is: R's second column holds only these two."""
    R = Rotation.from_quat(wxyz, scalar_first=True).as_matrix()
    return float(np.arctan2(R[2, 1], R[1, 1])), float(-np.arcsin(np.clip(R[0, 1], -1.0, 1.0)))


def _quaternion(R: FloatArray) -> FloatArray:
    return np.asarray(Rotation.from_matrix(R).as_quat(scalar_first=True))
