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

from pipeline.arrays import FloatArray
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
    spread : (5 k, 5 n)
        Spline basis: actuators (5 k,) = spread @ coefficients (5 n,).
    """

    machine: Machine
    s: FloatArray
    knots: FloatArray
    steps: FloatArray
    exponent: float
    spread: csr_array

    @cached_property
    def squared(self) -> csr_array:
        """The squared change of the actuators, integrated over s, as a form in that of the coefficients. Square."""
        return csr_array(self.spread.T @ diags_array(np.repeat(np.gradient(self.s), 5)) @ self.spread)

    @classmethod
    def at(
        cls, machine: Machine, s: FloatArray, knots: FloatArray, steps: FloatArray, exponent: float
    ) -> "EvaluationPoints":
        """Evaluate splines with given knots at s (k,); `exponent` is that of the smooth kappa."""
        return cls(machine, s, knots, steps, exponent, csr_array(kron(basis(knots, s), eye_array(5))))


@dataclass(frozen=True, eq=False)
class Iterate:
    """A path at its k evaluation points.

    Attributes
    ----------
    coefficients : (n, 5)
        Coefficients of its splines.
    samples : PoseSamples
        Poses and actuators.
    kappa, kappa_slope : (k,), (k, 5)
        The smooth condition number and its derivative by the actuators there.
    moves : (k, 6, 5)
        Derivative of the pose by the actuators.
    chords : (k - 1, 5)
        Moves from point to point in the metric of the route.
    """

    coefficients: FloatArray
    samples: PoseSamples
    kappa: FloatArray
    kappa_slope: FloatArray
    moves: FloatArray
    chords: FloatArray

    @property
    def distances(self) -> FloatArray:
        """Lengths of the chords, (k - 1,)."""
        return np.asarray(np.linalg.norm(self.chords, axis=1), dtype=float)

    @property
    def integral(self) -> float:
        """The integral of the smooth kappa by the trapezoidal rule."""
        return float(kappa_trapezoids(self.kappa, self.distances).sum())


def iterate_at(points: EvaluationPoints, coefficients: FloatArray, near: FloatArray) -> Iterate | None:
    """Evaluate splines with coefficients (n, 5), poses near given ones (k, 6); None where the closure is lost."""
    machine, q = points.machine, BSpline(points.knots, coefficients, DEGREE)(points.s)
    pose, miss = newton(machine, q, near)
    if not (miss < _CLOSED_M).all():
        return None
    samples, moves = PoseSamples(machine, pose, q), pose_jacobian(machine, pose, q)
    spectrum = smooth_condition(samples.H, points.exponent)
    H_slope = slopes(lambda beside: beside.H, samples, moves)
    return Iterate(
        coefficients=coefficients,
        samples=samples,
        kappa=spectrum.kappa,
        kappa_slope=np.einsum("kij,kijn->kn", spectrum.gradient, H_slope, optimize=True),
        moves=moves,
        chords=np.diff(samples.controlled, axis=0) / points.steps,
    )


def slopes(of: Callable[[PoseSamples], FloatArray], samples: PoseSamples, moves: FloatArray) -> FloatArray:
    """Differentiate a function of poses and actuators with values (k, ...) by the actuators. Shape (k, ..., 5).

    `moves` (k, 6, 5) is the derivative of the pose by the actuators.
    """
    columns = []
    for actuator in range(5):
        pose = _DIFFERENCE_M * moves[:, :, actuator]
        q = np.where(np.arange(5) == actuator, _DIFFERENCE_M, 0.0)
        ahead = of(PoseSamples(samples.machine, samples.pose + pose, samples.q_m + q))
        behind = of(PoseSamples(samples.machine, samples.pose - pose, samples.q_m - q))
        columns.append((ahead - behind) / (2.0 * _DIFFERENCE_M))
    return np.stack(columns, axis=-1)
