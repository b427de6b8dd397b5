"""The actuators that bring a machine to poses that were planned for another one, as near as it can be.

With planned splines q(s) and poses p(s), and the pose f(q) of the machine as it is, splines dq(s) over the same knots

    minimise  int |W (f(q + dq) - p)|^2 ds + w int |dq''|^2 ds

over x, y, z, rx, rz, with angles times the machine's characteristic length, by Gauss and Newton's method in a trust
region. Inverse kinematics would solve the same pose by pose, and fail: where an arm changes its working mode the
planned pose is at the boundary of its reach, so that on another machine it is out of reach, or within it, and the cart
would have to jump. A smooth dq passes there, hardly farther from the planned poses than it has to be.

Start and goal are met exactly. Since q + dq are splines like those of any path, limits, singularities and time can be
proven as they are of any path.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import least_squares

from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import newton, pose_jacobian
from pipeline.machine.pose import CONTROLLED, wrap_angle
from pipeline.refine.result import Path

STAGE = "correct"
_BENDING = 1e-11
"""Weight w: a wave of dq that is shorter than a hundredth of the path costs more than the error it removes."""
_LEAST_SAMPLES, _SAMPLES_PER_COEFFICIENT = 1_001, 20
_CLOSED_M = 1e-9
_NOT_ASSEMBLED_M = 1.0
"""Error that stands for a machine that cannot be assembled: no step is taken there."""
_STEP_M = 1e-3
_TOLERANCE, _GRADIENT = 1e-7, 1e-13
_MOST_EVALUATIONS = 50


@dataclass(frozen=True, eq=False)
class Correction:
    """A corrected path.

    Attributes
    ----------
    planned : Path
        The path as planned, of the machine it was planned for.
    path : Path
        The corrected one, of the machine as it is.
    evaluations : int
        How often the poses along it were computed.
    """

    planned: Path
    path: Path
    evaluations: int

    def change_m(self, s: FloatArray) -> FloatArray:
        """Evaluate dq at s (n,), in the geometry of the machine. Shape (n, 5)."""
        return self.path.q(s) - self.planned.q(s)


def correct_path(planned: Path, machine: Machine, ends_m: tuple[FloatArray, FloatArray]) -> Correction:
    """Correct a planned path for another machine, whose actuators are at `ends_m`, (5,) each, at start and goal.

    Raises
    ------
    NoSolutionError
        When that machine cannot be assembled near the planned poses, or no correction is found.
    """
    spline = planned.spline
    count = max(_LEAST_SAMPLES, _SAMPLES_PER_COEFFICIENT * len(spline.c))
    s = np.linspace(0.0, 1.0, count)
    problem = _Problem(planned, machine, s, planned.pose(s), _held(planned, ends_m))
    found = least_squares(
        problem.residual,
        problem.first,
        problem.jacobian,
        method="trf",
        x_scale=_STEP_M,
        xtol=_TOLERANCE,
        ftol=_TOLERANCE,
        gtol=_GRADIENT,
        max_nfev=_MOST_EVALUATIONS,
    )
    if found.status <= 0:
        raise NoSolutionError(
            STAGE,
            f"no correction was found within {_MOST_EVALUATIONS} evaluations",
            "Plan again for this machine (--plan-again DIR).",
        )
    c = spline.c + problem.change(found.x)
    path = replace(planned, machine=machine, spline=BSpline(spline.t, c, spline.k))
    node_pose = _assembled(machine, path.q(planned.node_s), planned.node_pose, planned.node_s)
    return Correction(planned, replace(path, node_pose=node_pose), int(found.nfev))


def _held(planned: Path, ends_m: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Give the coefficients of dq that are known, those at both ends; NaN where they are free. Shape (n, 5).

    A path that comes with a time law begins and ends at rest: three coefficients are alike there.
    """
    held = np.full_like(planned.spline.c, np.nan)
    alike = 1 if planned.motion_s is None else 3
    start, goal = (at - planned.q(s) for at, s in zip(ends_m, (0.0, 1.0), strict=True))
    held[:alike], held[-alike:] = start, goal
    return np.asarray(held)


class _Problem:
    """The least-squares problem: errors of poses at n samples, and the bending of dq between knots."""

    def __init__(self, planned: Path, machine: Machine, s: FloatArray, pose: FloatArray, held: FloatArray) -> None:
        spline, length = planned.spline, machine.characteristic_length_m
        self._machine, self._pose, self._q, self._held = machine, pose, planned.q(s), held
        self._free = np.flatnonzero(np.isnan(held).ravel())
        unit = BSpline(spline.t, np.eye(len(spline.c)), spline.k)
        self._basis = unit(s)
        bends = np.linspace(0.0, 1.0, 4 * len(spline.c))
        self._bending = np.sqrt(_BENDING / len(bends)) * unit(bends, nu=2)
        self._weights = np.array([1.0, 1.0, 1.0, length, length]) / np.sqrt(len(s))
        _assembled(machine, self._q + self._basis @ self.change(self.first), pose, s)

    @property
    def first(self) -> FloatArray:
        """The first guess: dq changes evenly from start to goal. Shape (k,)."""
        part = np.linspace(0.0, 1.0, len(self._held))[:, None]
        even = (1.0 - part) * self._held[0] + part * self._held[-1]
        return np.asarray(even.ravel()[self._free])

    def change(self, x: FloatArray) -> FloatArray:
        """Give all coefficients of dq from the free ones (k,). Shape (n, 5)."""
        c = self._held.copy().ravel()
        c[self._free] = x
        return np.asarray(c.reshape(self._held.shape))

    def residual(self, x: FloatArray) -> FloatArray:
        """Weigh the errors of all poses, then the bending."""
        c = self.change(x)
        pose, miss = newton(self._machine, self._q + self._basis @ c, self._pose)
        errors = controlled_errors(pose, self._pose)
        errors[~(miss < _CLOSED_M)] = _NOT_ASSEMBLED_M
        return np.concatenate([(errors * self._weights).ravel(), (self._bending @ c).ravel()])

    def jacobian(self, x: FloatArray) -> FloatArray:
        """Differentiate the residuals by the free coefficients."""
        q = self._q + self._basis @ self.change(x)
        pose, _ = newton(self._machine, q, self._pose)
        rates = pose_jacobian(self._machine, pose, q)[:, CONTROLLED] * self._weights[:, None]
        by_poses = np.einsum("nij,na->niaj", rates, self._basis).reshape(rates.shape[0] * 5, -1)
        by_bends = np.einsum("na,ij->niaj", self._bending, np.eye(5)).reshape(len(self._bending) * 5, -1)
        return np.vstack([by_poses, by_bends])[:, self._free]


def controlled_errors(reached: FloatArray, planned: FloatArray) -> FloatArray:
    """Give x, y, z, rx, rz of poses (n, 6) less those that were planned (n, 6). Shape (n, 5)."""
    errors = (reached - planned)[:, CONTROLLED]
    errors[:, 3:] = wrap_angle(errors[:, 3:])
    return errors


def _assembled(machine: Machine, q_m: FloatArray, guess: FloatArray, s: FloatArray) -> FloatArray:
    """Find the poses (n, 6) of a machine at actuators (n, 5), near poses that were planned.

    Raises
    ------
    NoSolutionError
        Where it has none.
    """
    pose, miss = newton(machine, q_m, guess)
    if (apart := ~(miss < _CLOSED_M)).any():
        raise NoSolutionError(
            STAGE,
            f"the calibrated machine cannot be assembled near the planned pose at s = {s[np.argmax(apart)]:.4f}: it is "
            "too far from the one that was planned for",
            "Check that --machine is the calibration of this machine; plan again for it (--plan-again DIR).",
        )
    return pose


def poses_as_driven(
    planned: Path, machine: Machine, as_driven: Callable[[FloatArray], FloatArray], s: FloatArray
) -> FloatArray:
    """Find where a machine is, at s (n,), that is driven as planned. Shape (n, 6).

    Parameters
    ----------
    as_driven : callable
        Gives the actuators of this machine (n, 5) where the planned ones are commanded, see `machine.actuators`.

    Raises
    ------
    NoSolutionError
        Where it cannot be assembled.
    """
    return _assembled(machine, as_driven(planned.q(s)), planned.pose(s), s)
