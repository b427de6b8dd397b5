"""Maps of kappa over the YZ plane at one tilt in one working mode: where poses are good, where singular."""

from dataclasses import dataclass

import numpy as np

from pipeline.machine.geometry import FloatArray, Machine
from pipeline.machine.kinematics import inverse_kinematics
from pipeline.machine.statics import condition_number, statics_matrix


@dataclass(frozen=True, eq=False)
class KappaMap:
    """kappa and det H on a grid of the YZ plane; NaN out of reach.

    Attributes
    ----------
    y_m, z_m : (ny,), (nz,)
        Grid values.
    kappa, det : (nz, ny)
        Condition number and determinant of H, moments in metres.
    """

    y_m: FloatArray
    z_m: FloatArray
    kappa: FloatArray
    det: FloatArray

    @property
    def has_singularities(self) -> bool:
        """True when det H changes sign between neighbouring points that are both in reach.

        Signs that differ across a gap out of reach prove nothing: only cells wholly in reach count.
        """
        corners = np.stack([self.det[:-1, :-1], self.det[1:, :-1], self.det[:-1, 1:], self.det[1:, 1:]])
        # A corner out of reach makes both NaN, and no comparison with NaN is true.
        return bool(np.any((corners.min(axis=0) < 0.0) & (corners.max(axis=0) > 0.0)))


def kappa_map(machine: Machine, y_m: FloatArray, z_m: FloatArray, tilt_rad: tuple[float, float], mode: int) -> KappaMap:
    """Evaluate kappa and det H over y (ny,) and z (nz,) at tilt (rx, rz) in a working mode; x plays no role.

    Reach alone decides where there is a value: strokes, travel and clearance are not looked at.
    """
    y, z = np.meshgrid(y_m, z_m)
    controlled = np.zeros((y.size, 5))
    controlled[:, 1], controlled[:, 2] = y.ravel(), z.ravel()
    controlled[:, 3:] = tilt_rad
    solution = inverse_kinematics(machine, controlled, np.full(y.size, mode))
    rows = np.flatnonzero(solution.reachable)
    H = statics_matrix(machine, solution.pose[rows], solution.q_m[rows, :3])
    kappa, det = np.full(y.size, np.nan), np.full(y.size, np.nan)
    kappa[rows], det[rows] = condition_number(H), np.linalg.det(H)
    return KappaMap(y_m, z_m, kappa.reshape(y.shape), det.reshape(y.shape))
