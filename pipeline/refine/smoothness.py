"""The cost of a path that is not smooth: the third derivative of its actuators along s.

    S = w K_c mean_s |q''' / v|^2 / L_q^2,    L_q = mean_s |q' / v| along the coarse path,

with w = `refine.smoothness`, K_c the integral of kappa along the coarse path and v the velocity limits, is added to the
integral of kappa. The weight is absolute: the coarse path's own |q'''|^2 varies over nine orders of magnitude from task
to task, while its length in units of the velocity limits is much the same.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array, diags_array, kron

from pipeline.arrays import FloatArray
from pipeline.refine.result import Path
from pipeline.refine.splines import DEGREE

_GAUSS_POINTS = 3
"""Exact for the square of the third derivative of a quintic, a polynomial of degree four between knots."""
_SAMPLES = 1_001
_LEAST_SHARE = 1e-3
"""Share of the largest velocity limit that others count as at least: an actuator that must not move has no limit."""


@dataclass(frozen=True, eq=False)
class Smoothness:
    """The cost S of a coarse path's refinement.

    Attributes
    ----------
    weight : float
        w K_c / L_q^2.
    velocity_mps : (5,)
        v.
    """

    weight: float
    velocity_mps: FloatArray

    @classmethod
    def of(cls, smoothness: float, kappa_integral: float, coarse: Path) -> "Smoothness":
        """Scale w to a coarse path, given the integral of kappa along it."""
        limits = coarse.machine.velocity_mps
        velocity = np.maximum(limits, _LEAST_SHARE * limits.max())
        speed = coarse.q(np.linspace(0.0, 1.0, _SAMPLES), 1) / velocity
        return cls(float(smoothness * kappa_integral / np.linalg.norm(speed, axis=1).mean() ** 2), velocity)

    def form(self, knots: FloatArray) -> csr_array:
        """Write S as c . form . c, for the spline coefficients row by row, c (5 n,). Shape (5 n, 5 n)."""
        inner = np.unique(knots)
        nodes, weights = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
        half = np.diff(inner)[:, None] / 2.0
        at = (inner[:-1, None] + half * (1.0 + nodes)).ravel()
        third = csr_array(BSpline(knots, np.eye(len(knots) - DEGREE - 1), DEGREE)(at, nu=3))
        squared = third.T @ diags_array((half * weights).ravel()) @ third
        return csr_array(self.weight * kron(squared, diags_array(self.velocity_mps**-2.0)))
