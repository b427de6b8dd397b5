"""The quadratic program of a step: the objective expanded, constraints linearised about an iterate.

The largest kappa is a slack variable t. For changes d of the spline coefficients c, and S what is not smooth costs,

    minimise    w_1 (integral + its slope . d + d . its curvature . d / 2 + S(c + d)) / length of the coarse path
                + w_2 t + damping / 2 |d|^2
    subject to  kappa_k + its slope . d <= t at every point, target <= t <= cap, every constraint linearised,

a sparse convex program.
"""

import numpy as np
from scipy.sparse import block_diag, csr_array, vstack

from pipeline.arrays import FloatArray
from pipeline.refine.peak.constraints import by_unknowns
from pipeline.refine.peak.iterate import EvaluationPoints, Iterate
from pipeline.refine.peak.problem import PeakObjective, PeakProblem
from pipeline.refine.peak.speed import chord_curvature, chord_slopes
from pipeline.solvers import DampedProgram


class StepProgram:
    """The quadratic program of a step from an iterate, to be solved with different damping."""

    def __init__(self, problem: PeakProblem, objective: PeakObjective, iterate: Iterate) -> None:
        self._iterate, self._objective = iterate, objective
        points, size = problem.points, iterate.coefficients.size
        kappa_slope = by_unknowns(points, np.arange(len(points.s)), iterate.kappa_slope)
        peak = np.zeros(size + 2)
        peak[size] = 1.0
        rows = [csr_array(kappa_slope - csr_array(np.ones((len(points.s), 1))) @ csr_array(peak[None]))]
        low, high = [np.full(len(points.s), -np.inf)], [-iterate.kappa]
        for constraint in problem.constraints(iterate):
            value, least, largest = constraint.value, constraint.low, constraint.high
            near = np.flatnonzero((value - least < constraint.near) | (largest - value < constraint.near))
            if len(near):
                rows.append(constraint.slope(near))
                low.append((least - value)[near])
                high.append((largest - value)[near])
        weight = objective.mean_weight / objective.length
        slope = integral_slope(points, iterate, kappa_slope)
        rough = csr_array(block_diag([2.0 * objective.smoothness, csr_array((2, 2))]))
        slope += rough @ np.append(iterate.coefficients.ravel(), [0.0, 0.0])
        curvature = chord_curvature(points, iterate, weight * (iterate.kappa[1:] + iterate.kappa[:-1]) / 2.0)
        self._program = DampedProgram(
            hessian=csr_array(curvature + weight * rough),
            damping=block_diag([points.squared, csr_array((2, 2))]),
            gradient=weight * slope + objective.peak_weight * peak,
            matrix=vstack(rows),
            row_bounds=(np.concatenate(low), np.concatenate(high)),
            column_bounds=self._variable_bounds(problem.actuator_range_m),
        )

    def _variable_bounds(self, actuator_range_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        coefficients, target = self._iterate.coefficients, self._objective.target
        low, high = (actuator_range_m[:, side] - coefficients for side in (0, 1))
        for change in (low, high):
            change[[0, -1]] = 0.0
        length = float(self._iterate.distances.sum())
        cap = max(self._objective.cap, target)
        return np.append(low.ravel(), [target, -length / 2.0]), np.append(high.ravel(), [cap, length])

    def solve(self, damping: float) -> tuple[FloatArray | None, float]:
        """Find the change of the coefficients (n, 5) and the predicted gain; None if the solver fails."""
        x = self._program.solve(damping)
        if x is None:
            return None, 0.0
        before = self._objective.peak_weight * max(float(self._iterate.kappa.max()), self._objective.target)
        return x[:-2].reshape(-1, 5), before - self._program.value(x)


def integral_slope(points: EvaluationPoints, iterate: Iterate, kappa_slope: csr_array) -> FloatArray:
    """Differentiate the integral of the smooth kappa by the unknowns of a step. Shape (5 n + 2,)."""
    distances, kappa = iterate.distances, iterate.kappa
    shares = (np.append(distances, 0.0) + np.append(0.0, distances)) / 2.0
    by_chords = chord_slopes(points, iterate).T @ ((kappa[1:] + kappa[:-1]) / 2.0)
    return np.asarray(kappa_slope.T @ shares + by_chords, dtype=float)
