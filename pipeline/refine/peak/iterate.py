"""An SQP iterate: evaluation points, pose and kappa there, and their derivatives by the actuators.

The unknowns are the spline coefficients alone. The pose at a point follows from the actuators by forward kinematics, so
that the closure holds exactly on every iterate; derivatives are central differences along the motion that the actuators
force on the platform.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array, diags_array, eye_array, kron

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import newton, pose_jacobian
from pipeline.machine.samples import PoseSamples
from pipeline.machine.schatten import smooth_condition
from pipeline.refine.measure import kappa_trapezoids
from pipeline.refine.splines import DEGREE, basis

_DIFFERENCE_M = 1e-6
"""Half the width of the central differences."""
_CLOSED_M = 1e-9
"""Largest miss of a link with which a pose counts as found."""


@dataclass(frozen=True, eq=False)
class EvaluationPoints:
    """Where a path is evaluated.

    Attributes
    ----------
    s, knots : (k,), (n + 6,)
        Parameters of the points; knots of the splines.
    steps : (5,)
        The metric: largest moves per step of the route.
    exponent : float
        Exponent of the smooth kappa.
    """

    machine: Machine
    s: FloatArray
    knots: FloatArray
    steps: FloatArray
    exponent: float

    @property
    def coefficients(self) -> int:
        """Spline coefficients per actuator."""
        return len(self.knots) - DEGREE - 1

    @cached_property
    def basis(self) -> csr_array:
        """Spline basis (k, n), with `DEGREE` + 1 entries in every row: q = basis @ coefficients."""
        return basis(self.knots, self.s)

    @cached_property
    def squared(self) -> csr_array:
        """The squared change of the actuators, integrated over s, as a form in that of the coefficients. Square."""
        form = self.basis.T @ diags_array(np.gradient(self.s)) @ self.basis
        return csr_array(kron(form, eye_array(5)))


@dataclass(frozen=True, eq=False)
class Iterate:
    """A path at its k evaluation points; derivatives are computed when first needed.

    Attributes
    ----------
    coefficients : (n, 5)
        Coefficients of its splines.
    samples : PoseSamples
        Poses and actuators.
    kappa, kappa_gradient : (k,), (k, 6, 6)
        The smooth condition number and its derivative by H.
    chords : (k - 1, 5)
        Moves from point to point in the metric of the route.
    """

    coefficients: FloatArray
    samples: PoseSamples
    kappa: FloatArray
    kappa_gradient: FloatArray
    chords: FloatArray

    @cached_property
    def distances(self) -> FloatArray:
        """Lengths of the chords, (k - 1,)."""
        return np.asarray(np.linalg.norm(self.chords, axis=1), dtype=float)

    @property
    def integral(self) -> float:
        """The integral of the smooth kappa by the trapezoidal rule."""
        return float(kappa_trapezoids(self.kappa, self.distances).sum())

    @cached_property
    def moves(self) -> FloatArray:
        """Derivative of the pose by the actuators, (k, 6, 5)."""
        return pose_jacobian(self.samples.machine, self.samples.pose, self.samples.q_m)

    @cached_property
    def kappa_slope(self) -> FloatArray:
        """Derivative of the smooth kappa by the actuators, (k, 5)."""
        H_slope = self.slopes(lambda samples: samples.H)
        return np.asarray(np.einsum("kij,kijn->kn", self.kappa_gradient, H_slope, optimize=True), dtype=float)

    def slopes(self, of: Callable[[PoseSamples], FloatArray]) -> FloatArray:
        """Differentiate a function of poses and actuators with values (k, ...) by the actuators. Shape (k, ..., 5)."""
        return _central_differences(of(self._beside))

    def slopes_at(self, points: IntArray, of: Callable[[PoseSamples], FloatArray]) -> FloatArray:
        """Differentiate such a function at some of the points (m,) only. Shape (m, ..., 5)."""
        beside = np.arange(0, len(self._beside), len(self.samples))[:, None] + points
        return _central_differences(of(self._beside.take(beside.ravel())))

    @cached_property
    def _beside(self) -> PoseSamples:
        """All points with every actuator moved ahead, (5 k,), then behind."""
        pose = _DIFFERENCE_M * np.moveaxis(self.moves, -1, 0)
        q = np.broadcast_to(_DIFFERENCE_M * np.eye(5)[:, None], (5, len(self.samples), 5))
        samples = self.samples
        return PoseSamples(
            samples.machine,
            np.concatenate([samples.pose + pose, samples.pose - pose]).reshape(-1, 6),
            np.concatenate([samples.q_m + q, samples.q_m - q]).reshape(-1, 5),
        )


def _central_differences(beside: FloatArray) -> FloatArray:
    """Differentiate by the actuators, given values (10 k, ...) with each moved ahead, then behind. (k, ..., 5)."""
    ahead, behind = beside.reshape(2, 5, -1, *beside.shape[1:])
    return np.moveaxis((ahead - behind) / (2.0 * _DIFFERENCE_M), 0, -1)


def iterate_at(points: EvaluationPoints, coefficients: FloatArray, near: FloatArray) -> Iterate | None:
    """Evaluate splines with coefficients (n, 5), poses near given ones (k, 6); None where the closure is lost."""
    q = BSpline(points.knots, coefficients, DEGREE)(points.s)
    pose, miss = newton(points.machine, q, near)
    if not (miss < _CLOSED_M).all():
        return None
    samples = PoseSamples(points.machine, pose, q)
    spectrum = smooth_condition(samples.H, points.exponent)
    return Iterate(
        coefficients=coefficients,
        samples=samples,
        kappa=spectrum.kappa,
        kappa_gradient=spectrum.gradient,
        chords=np.diff(samples.controlled, axis=0) / points.steps,
    )
