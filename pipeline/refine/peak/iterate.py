"""A path while its largest kappa is brought down: where it is looked at, what it does there, and how that changes.

The unknowns are the spline coefficients alone. The pose at a look follows the actuators by forward kinematics, so that
the closure holds exactly on every iterate; how anything changes with the actuators there is a central difference along
the motion that they force on the platform.
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
from pipeline.machine.schatten import smooth_condition
from pipeline.machine.statics import statics_matrix
from pipeline.refine.splines import DEGREE, basis
from pipeline.route.metric import CONTROLLED

_DIFFERENCE_M = 1e-6
"""Half the width of the central differences."""
_CLOSED_M = 1e-9
"""Largest miss of a link with which a pose counts as found."""


@dataclass(frozen=True, eq=False)
class EvaluationPoints:
    """Where a path is looked at: s (k,), and the basis there, actuators (5 k,) = `spread` @ coefficients (5 n,)."""

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
        """Look at s (k,) of splines with given knots; `exponent` is that of the smooth kappa."""
        return cls(machine, s, knots, steps, exponent, csr_array(kron(basis(knots, s), eye_array(5))))


@dataclass(frozen=True, eq=False)
class Iterate:
    """What a path does where it is looked at.

    Attributes
    ----------
    coefficients : (n, 5)
        Of its splines.
    q_m, pose : (k, 5), (k, 6)
        Actuators and poses.
    kappa, kappa_slope : (k,), (k, 5)
        The smooth condition number and its derivative by the actuators there.
    moves : (k, 6, 5)
        Derivative of the pose by the actuators.
    chords : (k - 1, 5)
        Moves from look to look in the metric of the route.
    """

    coefficients: FloatArray
    q_m: FloatArray
    pose: FloatArray
    kappa: FloatArray
    kappa_slope: FloatArray
    moves: FloatArray
    chords: FloatArray

    @property
    def distances(self) -> FloatArray:
        """Lengths of the chords, (k - 1,)."""
        lengths: FloatArray = np.linalg.norm(self.chords, axis=1)
        return lengths

    @property
    def integral(self) -> float:
        """The integral of the smooth kappa by the trapezoidal rule."""
        return float(np.sum(self.distances * (self.kappa[1:] + self.kappa[:-1])) / 2.0)


def iterate_at(looks: EvaluationPoints, coefficients: FloatArray, near: FloatArray) -> Iterate | None:
    """Evaluate splines with coefficients (n, 5), poses near given ones (k, 6); None where the closure is lost."""
    machine, q = looks.machine, BSpline(looks.knots, coefficients, DEGREE)(looks.s)
    pose, miss = newton(machine, q, near)
    if not (miss < _CLOSED_M).all():
        return None
    moves = pose_jacobian(machine, pose, q)
    spectrum = smooth_condition(statics_matrix(machine, pose, q[:, :3]), looks.exponent)
    H_slope = slopes(lambda p, carts: statics_matrix(machine, p, carts), pose, q, moves)
    return Iterate(
        coefficients=coefficients,
        q_m=q,
        pose=pose,
        kappa=spectrum.kappa,
        kappa_slope=np.einsum("kij,kijn->kn", spectrum.gradient, H_slope, optimize=True),
        moves=moves,
        chords=np.diff(pose[:, CONTROLLED], axis=0) / looks.steps,
    )


def slopes(
    of: Callable[[FloatArray, FloatArray], FloatArray], pose: FloatArray, q_m: FloatArray, moves: FloatArray
) -> FloatArray:
    """Differentiate a function of poses (k, 6) and carts (k, 3) with values (k, ...) by the actuators. (k, ..., 5)."""
    columns = []
    for actuator in range(5):
        shift = _DIFFERENCE_M * moves[:, :, actuator]
        carts = np.where(np.arange(3) == actuator, _DIFFERENCE_M, 0.0)
        ahead, behind = of(pose + shift, q_m[:, :3] + carts), of(pose - shift, q_m[:, :3] - carts)
        columns.append((ahead - behind) / (2.0 * _DIFFERENCE_M))
    return np.stack(columns, axis=-1)
