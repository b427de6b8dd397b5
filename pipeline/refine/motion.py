"""The pose along a path and its derivatives by s, and a spline of controlled poses for work in pose space."""

import numpy as np
from scipy.interpolate import BSpline

from pipeline.arguments import require_array, require_number
from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.machine.pose import CONTROLLED
from pipeline.machine.statics import condition_number, statics_matrix
from pipeline.machine.symbolic import closure_terms_function
from pipeline.refine.result import Path
from pipeline.refine.splines import DEGREE, clamped_knots, fit

_POSE = 6
_MOST_COEFFICIENTS = 4_000


def pose_derivatives(path: Path, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Compute the pose and its first three derivatives by s at s (n,), each (n, 6), by implicit differentiation.

    With z = (p, q), F(z(s)) = 0, and the order of differentiation by s as a number after each quantity:
    F_p p1 = -F_q q1, F_p p2 = -F_q q2 - F_zz[z1, z1], F_p p3 = -F_q q3 - 3 F_zz[z1, z2] - F_zzz[z1, z1, z1].

    Raises
    ------
    ArgumentError
        If s has another shape, or is outside [0, 1].
    ForwardKinematicsError
        If the closure equations have no solution near the path's known poses.
    """
    s = require_array("s", np.atleast_1d(s), ("n",))
    terms = closure_terms_function(path.machine).map(len(s))
    pose, (q1, q2, q3) = path.pose(s), (path.q(s, order) for order in (1, 2, 3))
    z, none = np.column_stack([pose, path.q(s)]), np.zeros((len(s), 11))
    by_z = np.array(terms(z.T, none.T, none.T)[0]).reshape(_POSE, len(s), 11).transpose(1, 0, 2)
    by_pose, by_q = by_z[:, :, :_POSE], by_z[:, :, _POSE:]

    def solve(q_derivative: FloatArray, known: FloatArray) -> FloatArray:
        right = np.einsum("nij,nj->ni", by_q, q_derivative) + known
        return np.asarray(-np.linalg.solve(by_pose, right[..., None])[..., 0], dtype=float)

    first = solve(q1, np.zeros((len(s), _POSE)))
    along = np.column_stack([first, q1])
    second = solve(q2, np.array(terms(z.T, along.T, none.T)[1]).T)
    bend = np.column_stack([second, q2])
    _, _, mixed, thrice = terms(z.T, along.T, bend.T)
    third = solve(q3, 3.0 * np.array(mixed).T + np.array(thrice).T)
    return pose, first, second, third


def kappa_along(path: Path, s: FloatArray) -> FloatArray:
    """Compute the condition number at s (n,). Shape (n,).

    Raises
    ------
    ArgumentError
        If s has another shape, or is outside [0, 1].
    """
    s = require_array("s", np.atleast_1d(s), ("n",))
    return condition_number(statics_matrix(path.machine, path.pose(s), path.q(s)[:, :3]))


def pose_spline(path: Path, tolerance_m: float = 1e-5, tolerance_rad: float = 1e-5) -> BSpline:
    """Fit a quintic spline of controlled poses (x, y, z, rx, rz) over s that stays within the tolerances.

    Coefficients (n, 5), doubled until it does; start and goal are met exactly. The spline does not hold the working
    mode: whoever needs it has to keep track of its changes.

    Raises
    ------
    ArgumentError
        If a tolerance is negative, or no finite number.
    NoSolutionError
        If no reasonable number of coefficients reaches the tolerances.
    """
    tolerance_m = require_number("tolerance_m", tolerance_m, least=0.0)
    tolerance_rad = require_number("tolerance_rad", tolerance_rad, least=0.0)
    limits = np.array([tolerance_m] * 3 + [tolerance_rad] * 2)
    coefficients = 32
    while coefficients <= _MOST_COEFFICIENTS:
        knots = clamped_knots(coefficients)
        samples = np.linspace(0.0, 1.0, 8 * coefficients + 1)
        spline = BSpline(knots, fit(knots, samples, path.pose(samples)[:, CONTROLLED]), DEGREE)
        between = (samples[1:] + samples[:-1]) / 2.0
        error = np.abs(spline(between) - path.pose(between)[:, CONTROLLED]).max(axis=0)
        if (error <= limits).all():
            return spline
        coefficients *= 2
    raise NoSolutionError(
        "refine",
        f"no spline of up to {_MOST_COEFFICIENTS} coefficients follows the pose within the tolerances; the last one is "
        f"off by {error[:3].max():.2e} m and {error[3:].max():.2e} rad",
        "Allow a larger tolerance.",
    )
