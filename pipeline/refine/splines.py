"""Quintic B-splines in actuator space: clamped knots, sparse basis, least-squares fit."""

import numpy as np
from scipy.interpolate import BSpline, make_lsq_spline
from scipy.sparse import csr_array

from pipeline.arrays import FloatArray

DEGREE = 5
"""Quintic: q has four continuous derivatives, so that acceleration and jerk are smooth along the path."""


def clamped_knots(coefficients: int) -> FloatArray:
    """Space knots evenly on [0, 1] for a clamped spline with that many coefficients. Shape (coefficients + 6,)."""
    inner = np.linspace(0.0, 1.0, coefficients - DEGREE + 1)
    return np.concatenate([np.zeros(DEGREE), inner, np.ones(DEGREE)])


def basis(knots: FloatArray, s: FloatArray) -> csr_array:
    """Evaluate all basis functions at s (k,): q(s) = basis @ coefficients. Shape (k, coefficients)."""
    return csr_array(BSpline.design_matrix(s, knots, DEGREE))


def fit(knots: FloatArray, s: FloatArray, q_m: FloatArray) -> FloatArray:
    """Fit coefficients (n, 5) to samples q (k, 5) at s (k,) by least squares; the ends are met exactly."""
    coefficients: FloatArray = make_lsq_spline(s, q_m, knots, DEGREE).c
    coefficients[0], coefficients[-1] = q_m[0], q_m[-1]
    return coefficients
