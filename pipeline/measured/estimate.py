"""The controlled pose from two measured reflectors, with ry from the model, and how uncertain it is.

With the reflectors r_1, r_2 in the platform frame, m_i = p + R r_i measured, R = Rx(rx) Rz(rz) Ry(ry), d = r_2 - r_1:

    m_2 - m_1 = Rx(rx) Rz(rz) e,  e = Ry(ry) d,    p = (m_1 + m_2) / 2 - R (r_1 + r_2) / 2.

With noise that is equal and independent in all coordinates, the least squares over all six separate into these two
equations. The first asks for the rotation that makes R d point along v = m_2 - m_1. Rx does not change x coordinates,
so that, with v scaled to the length of d,

    v_x = e_x cos(rz) - e_y sin(rz)    gives rz (of two solutions, the one nearer to the command),
    (v_y, v_z) = Rot(rx) (f_y, f_z)    gives rx, with f = Rz(rz) e.

Where f_y = 0, the two solutions for rz coincide and rz is undetermined: d must not be along the platform's x or z axis.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arguments import require_array
from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.machine.geometry import cross, dot, rotation, rotation_x
from pipeline.machine.pose import CONTROLLED, wrap_angle
from pipeline.measured.reflectors import Reflectors
from pipeline.measured.rows import RowError

_LEAST_LEVER = 0.05
"""Least |f_y| / |d|: below, noise in rz is amplified more than twentyfold, and linearisation fails."""
_MOST_STRETCH, _MOST_DEVIATIONS = 0.05, 10.0
"""Largest error of the distance between the reflectors: as a fraction of it, and in standard deviations of noise."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Measured controlled poses.

    Attributes
    ----------
    controlled : (n, 5)
        x, y, z in metres, rx, rz in radians.
    std : (n, 5)
        Their standard deviations, due to noise in the coordinates of the reflectors.
    """

    controlled: FloatArray
    std: FloatArray


def estimate_poses(reflectors: Reflectors, positions_m: FloatArray, commanded: FloatArray) -> Estimate:
    """Estimate x, y, z, rx, rz from measured reflectors (n, 2, 3), with ry and the branch of commanded poses (n, 6).

    Raises
    ------
    UsageError
        When both reflectors are at one place, do not determine rz at some pose, or cannot be where they were measured;
        when positions or poses have another shape or are not finite. A `RowError` where one row is the reason.
    """
    commanded = require_array("commanded poses", commanded, ("n", 6))
    positions_m = require_array("measured reflectors", positions_m, (len(commanded), 2, 3))
    ry = commanded[:, 4]
    arm = reflectors.points_m[1] - reflectors.points_m[0]
    length = float(np.linalg.norm(arm))
    if not length > 0.0:
        raise UsageError("both reflectors are in one place: give two different places on the platform")
    v = positions_m[:, 1] - positions_m[:, 0]
    _require_seen(reflectors, v, rotation(commanded[:, 3], ry, commanded[:, 5]) @ arm)
    v = v * (length / np.linalg.norm(v, axis=1, keepdims=True))
    rx, rz, lever = _angles(_turned_about_y(arm, ry), v, commanded[:, 5])
    if (weak := np.abs(lever) < _LEAST_LEVER * length).any():
        row = int(np.argmax(weak))
        raise RowError(
            "the reflectors do not determine rz: they hardly move along X when the platform turns "
            "about z.\n  What to change: place them along the platform's y axis.",
            row,
        )
    R = rotation(rx, ry, rz)
    p = positions_m.mean(axis=1) - R @ reflectors.points_m.mean(axis=0)
    return Estimate(np.column_stack([p, rx, rz]), reflectors.noise_m * _unit_std(reflectors.points_m, R, rx))


def _require_seen(reflectors: Reflectors, v: FloatArray, expected: FloatArray) -> None:
    """Refuse measured vectors between reflectors (n, 3) that differ from those expected (n, 3) by more than noise."""
    length, distance = np.linalg.norm(expected, axis=1), np.linalg.norm(v, axis=1)
    allowed = np.maximum(_MOST_STRETCH * length, _MOST_DEVIATIONS * reflectors.noise_m)
    if (off := np.abs(distance - length) > allowed).any() or (off := ~(distance > 0.0)).any():
        row = int(np.argmax(off))
        raise RowError(
            f"the measured reflectors are {distance[row]:g} m apart, but {length[row]:g} m on the "
            "platform.\n  What to change: give positions in metres, and the true places of the reflectors.",
            row,
        )
    if (turned := dot(v, expected) < 0.0).any():
        row = int(np.argmax(turned))
        raise RowError(
            "the vector from the first measured reflector to the second points the wrong way.\n"
            "  What to change: swap the reflectors, or give positions in the frame of the machine.",
            row,
        )


def _turned_about_y(arm: FloatArray, ry: FloatArray) -> FloatArray:
    """Compute e = Ry(ry) d. Shape (n, 3)."""
    zero = np.zeros_like(ry)
    return np.asarray(rotation(zero, ry, zero) @ arm)


def _angles(e: FloatArray, v: FloatArray, near_rz: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Solve Rx Rz e = v for rx and rz; the third result, f_y, shows how well rz is determined. Three arrays (n,)."""
    # v_x = radius cos(rz + phase); an arm along z has no radius, and no lever either.
    radius = np.hypot(e[:, 0], e[:, 1])
    phase = np.arctan2(e[:, 1], e[:, 0])
    opening = np.arccos(np.clip(v[:, 0] / np.maximum(radius, 1e-300), -1.0, 1.0))
    both = wrap_angle(np.stack([opening - phase, -opening - phase]))
    nearer = np.argmin(np.abs(wrap_angle(both - near_rz)), axis=0)
    rz = np.take_along_axis(both, nearer[None], axis=0)[0]
    f_y = e[:, 0] * np.sin(rz) + e[:, 1] * np.cos(rz)
    rx = wrap_angle(np.arctan2(v[:, 2], v[:, 1]) - np.arctan2(e[:, 2], f_y))
    return rx, rz, f_y


def _unit_std(points_m: FloatArray, R: FloatArray, rx: FloatArray) -> FloatArray:
    """Compute the standard deviations of the estimate per metre of noise: roots of the diagonal of (J' J)^-1. (n, 5).

    J differentiates all six coordinates by x, y, z, rx, rz: identities, e_x x R r_i, and (Rx e_z) x R r_i.
    """
    J = np.zeros((len(R), 2, 3, len(CONTROLLED)))
    J[..., :3] = np.eye(3)
    arms = points_m @ np.swapaxes(R, 1, 2)
    axis_x = np.broadcast_to([1.0, 0.0, 0.0], arms.shape)
    axis_z = np.broadcast_to(rotation_x(rx)[:, None, :, 2], arms.shape)
    J[..., 3], J[..., 4] = cross(axis_x, arms), cross(axis_z, arms)
    stacked = J.reshape(len(R), 6, len(CONTROLLED))
    covariance = np.linalg.inv(np.swapaxes(stacked, 1, 2) @ stacked)
    return np.asarray(np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)))
