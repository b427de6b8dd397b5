"""Maps of kappa over the YZ plane at one tilt in one working mode: where poses are well-conditioned or singular."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeline.arguments import require_array, require_whole
from pipeline.arrays import FloatArray, IntArray
from pipeline.config import GridConfig
from pipeline.machine.geometry import MODES, Machine
from pipeline.machine.kinematics import inverse_kinematics
from pipeline.machine.rails import with_parallel_rails
from pipeline.machine.statics import moment_unit, statics_matrix

_COARSE_POINTS = 40
_MARGIN_M = 0.05
_NOTHING = 1e-14
"""Least eigenvalue of H'H, relative to the largest, that counts as none."""


class YzWindow(NamedTuple):
    """The part of the YZ plane that is shown, in metres."""

    y_least: float
    y_largest: float
    z_least: float
    z_largest: float


@dataclass(frozen=True, eq=False)
class KappaMap:
    """kappa and det H on a grid of the YZ plane; NaN out of reach.

    Attributes
    ----------
    y_m, z_m : (ny,), (nz,)
        Grid values.
    kappa, det : (nz, ny)
        Condition number and determinant of H.
    moment_unit : str
        What moments are measured in.
    """

    y_m: FloatArray
    z_m: FloatArray
    kappa: FloatArray
    det: FloatArray
    moment_unit: str = "moments in m"

    @property
    def has_singularities(self) -> bool:
        """True when det H changes sign between neighbouring points that are both in reach.

        Different signs across a gap out of reach prove nothing: only cells completely in reach count.
        """
        corners = np.stack([self.det[:-1, :-1], self.det[1:, :-1], self.det[:-1, 1:], self.det[1:, 1:]])
        # A corner out of reach makes both NaN, and no comparison with NaN is true.
        return bool(np.any((corners.min(axis=0) < 0.0) & (corners.max(axis=0) > 0.0)))


def kappa_map(machine: Machine, y_m: FloatArray, z_m: FloatArray, tilt_rad: tuple[float, float], mode: int) -> KappaMap:
    """Evaluate kappa and det H over y (ny,) and z (nz,) at tilt (rx, rz) in a working mode; they do not depend on x.

    Only reach decides where there is a value: strokes, travel and clearance are not checked. Rails are taken as
    parallel to X (`with_parallel_rails`).

    Raises
    ------
    ArgumentError
        If y, z or the tilt have other shapes or hold what is no finite number, or there is no such mode.
    """
    y_m, z_m = require_array("y_m", y_m, ("ny",)), require_array("z_m", z_m, ("nz",))
    tilt = require_array("tilt_rad", tilt_rad, (2,))
    mode = require_whole("mode", mode, 0, len(MODES) - 1)
    machine = with_parallel_rails(machine)
    y, z = np.meshgrid(y_m, z_m)
    controlled = np.zeros((y.size, 5))
    controlled[:, 1], controlled[:, 2] = y.ravel(), z.ravel()
    controlled[:, 3:] = tilt
    solution = inverse_kinematics(machine, controlled, np.full(y.size, mode))
    rows = np.flatnonzero(solution.reachable)
    H = statics_matrix(machine, solution.pose[rows], solution.q_m[rows, :3])
    kappa, det = np.full(y.size, np.nan), np.full(y.size, np.nan)
    kappa[rows], det[rows] = _condition_number(H), np.linalg.det(H)
    return KappaMap(y_m, z_m, kappa.reshape(y.shape), det.reshape(y.shape), moment_unit(machine))


def _condition_number(H: FloatArray) -> FloatArray:
    """Compute cond_2(H) from the eigenvalues of H'H: less exact than singular values (about 1e-16 kappa^2), and faster.

    Beyond 1e7, where nothing is left of the least eigenvalue, it is infinite. Shape (n,).
    """
    eigenvalues = np.linalg.eigvalsh(np.swapaxes(H, -1, -2) @ H)
    least, largest = eigenvalues[:, 0], eigenvalues[:, -1]
    known = least > _NOTHING * largest
    return np.asarray(np.where(known, np.sqrt(largest / np.where(known, least, 1.0)), np.inf))


def seen_window(
    grid: GridConfig, machine: Machine, tilts_rad: FloatArray, modes: IntArray, points_yz: Sequence[FloatArray]
) -> YzWindow:
    """Bound what is shown: whatever of the grid can be reached at some tilt, and points (m, 2).

    Parameters
    ----------
    tilts_rad : (n, 2)
        rx and rz of each map that is to be shown.
    modes : (n,)
        Their working modes.
    """
    machine = with_parallel_rails(machine)
    y, z = np.meshgrid(*(np.linspace(axis.min, axis.max, _COARSE_POINTS) for axis in (grid.y_m, grid.z_m)))
    seen = list(points_yz)
    for tilt, mode in zip(tilts_rad, modes, strict=True):
        controlled = np.column_stack([np.zeros(y.size), y.ravel(), z.ravel(), np.tile(tilt, (y.size, 1))])
        reachable = inverse_kinematics(machine, controlled, np.full(y.size, mode)).reachable
        seen.append(controlled[reachable, 1:3])
    points = np.concatenate(seen)
    (y_least, z_least), (y_largest, z_largest) = points.min(axis=0) - _MARGIN_M, points.max(axis=0) + _MARGIN_M
    return YzWindow(float(y_least), float(y_largest), float(z_least), float(z_largest))
