"""The machine that explains what a tracker saw, by weighted least squares with what is known beforehand.

With deviations theta of all parameters, reflectors m_i(theta) seen at y_i with noise sigma, and prior deviations s_k,

    minimise  sum_i w_i |m_i(theta) - y_i|^2 / sigma^2 + sum_k (theta_k / s_k)^2,

the most probable machine where errors are normally distributed. The prior settles whatever no measurement can tell.
Covariance is the inverse of the normal matrix. If the model is right, the least value is distributed as chi-square with
as many degrees of freedom as there are coordinates less the six of the tracker's frame, of which nothing is known.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from pipeline.arrays import BoolArray, FloatArray
from pipeline.calibrate.data.poses import StaticPoses
from pipeline.calibrate.data.seen import close_at, seen_jacobian
from pipeline.calibrate.model.forward import positions
from pipeline.calibrate.model.model import Model
from pipeline.calibrate.model.parameters import TRACKER
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import PRIMARY, dot, rotation
from pipeline.machine.working_modes import mode_names

_FRAME_STEP = 1e-3
"""Size of a step of the tracker's frame and clock, in metres, radians and seconds, for which there is no prior."""
_CLOSED_M = 1e-9
_NOT_ASSEMBLED = 1e6
"""Residual, in deviations of noise, where a machine cannot be assembled: no step of the solver is taken there."""
_TOLERANCE = 1e-8


@dataclass(frozen=True, eq=False)
class Problem:
    """What is to be explained, and by what.

    Attributes
    ----------
    model : Model
        The machine as configured, in a first estimate of the tracker's frame.
    poses : StaticPoses
        What was measured.
    guess : (n, 6)
        Poses of the configured machine, from which every other is assembled.
    noise_m : float
        Standard deviation of every coordinate.
    prior_std : (count,)
        Standard deviation of every parameter; infinite for the tracker's frame and clock.
    is_fitted : (count,)
        Parameters that may change.
    weights : (n, reflectors)
        Weights of points, 1 unless the fit is robust.
    """

    model: Model
    poses: StaticPoses
    guess: FloatArray
    noise_m: float
    prior_std: FloatArray
    is_fitted: BoolArray
    weights: FloatArray

    @property
    def scales(self) -> FloatArray:
        """Size of a step of each fitted parameter. Shape (fitted,)."""
        std = self.prior_std[self.is_fitted]
        return np.where(np.isfinite(std), std, _FRAME_STEP)

    def data_jacobian(self, theta: FloatArray, pose: FloatArray) -> FloatArray:
        """Differentiate seen coordinates by fitted parameters, in their scales and that of noise. Shape (m, fitted)."""
        seen, model = self.poses.is_seen, self.model.moved(theta)
        closed = close_at(model, self.poses, pose)
        J = seen_jacobian(model, self.poses, closed)
        # Where a machine is not assembled, the solver is kept away by its residuals.
        J[~(closed.miss_m < _CLOSED_M)] = 0.0
        J = J[seen]
        frame = model.parameters.slice(TRACKER).start
        J[..., frame : frame + 3] = J[..., frame : frame + 3] @ _left_jacobian(theta[frame : frame + 3])
        J = J[..., self.is_fitted]
        J *= (np.sqrt(self.weights[seen]) / self.noise_m)[:, None, None]
        return np.asarray(J.reshape(-1, J.shape[-1]) * self.scales)

    def full(self, x: FloatArray) -> FloatArray:
        """Give deviations of all parameters from those fitted, in their scales. Shape (count,)."""
        theta = np.zeros(len(self.is_fitted))
        theta[self.is_fitted] = x * self.scales
        return theta


@dataclass(frozen=True, eq=False)
class Identification:
    """A machine that was identified.

    Attributes
    ----------
    problem : Problem
        What it is the answer to.
    theta : (count,)
        Deviations of all parameters from the configured machine.
    covariance : (count, count)
        Of all parameters; zero for those that were not fitted.
    model : Model
        The machine.
    pose : (n, 6)
        Its poses.
    residual_m : (n, reflectors, 3)
        Seen less predicted; NaN where nothing was seen.
    jacobian : (m, fitted)
        Of the seen coordinates, in units of noise and of the prior.
    evaluations : int
        How often the machine was computed.
    """

    problem: Problem
    theta: FloatArray
    covariance: FloatArray
    model: Model
    pose: FloatArray
    residual_m: FloatArray
    jacobian: FloatArray
    evaluations: int

    @property
    def std(self) -> FloatArray:
        """Standard deviations of all parameters. Shape (count,)."""
        return np.asarray(np.sqrt(np.diagonal(self.covariance)))

    @property
    def data_chi2(self) -> float:
        """Sum of the squared residuals in units of noise."""
        seen = self.problem.poses.is_seen
        return float(np.sum(self.residual_m[seen] ** 2) / self.problem.noise_m**2)

    @property
    def chi2(self) -> float:
        """The least value: of residuals and of deviations from what is known beforehand."""
        return self.data_chi2 + float(np.sum((self.theta / self.problem.prior_std) ** 2))

    @property
    def freedom(self) -> int:
        """Degrees of freedom of `chi2`."""
        unknown = np.count_nonzero(self.problem.is_fitted & ~np.isfinite(self.problem.prior_std))
        return 3 * int(np.count_nonzero(self.problem.poses.is_seen)) - int(unknown)

    @property
    def data_freedom(self) -> float:
        """Mean of `data_chi2` if the model is right: coordinates less what the parameters take up of them."""
        J = self.jacobian
        normal = J.T @ J
        taken = np.trace(np.linalg.solve(normal + np.diag(_prior_rows(self.problem)), normal))
        return float(len(J) - taken)

    def predicted_covariance(self, poses: StaticPoses, guess: FloatArray) -> FloatArray:
        """Give the covariance of where reflectors are at other poses, noise left out. Shape (n, reflectors, 3, 3)."""
        J = seen_jacobian(self.model, poses, close_at(self.model, poses, guess))
        return np.asarray(J @ self.covariance @ np.swapaxes(J, -1, -2))


def identify(problem: Problem) -> Identification:
    """Find the most probable machine by Levenberg and Marquardt's method, with analytic derivatives.

    Raises
    ------
    NoSolutionError
        When the machine it ends at cannot be assembled at a pose.
    """
    poses, seen = problem.poses, problem.poses.is_seen
    root = np.sqrt(problem.weights[seen])[:, None] / problem.noise_m
    prior = np.sqrt(_prior_rows(problem))

    def residual(x: FloatArray) -> FloatArray:
        model = problem.model.moved(problem.full(x))
        closed = close_at(model, poses, problem.guess)
        rows = root * (positions(model, closed) - poses.seen_m)[seen]
        rows[(np.broadcast_to(~(closed.miss_m[:, None] < _CLOSED_M), seen.shape))[seen]] = _NOT_ASSEMBLED
        return np.concatenate([rows.ravel(), prior * x])

    def jacobian(x: FloatArray) -> FloatArray:
        data = problem.data_jacobian(problem.full(x), problem.guess)
        return np.vstack([data, np.diag(prior)])

    found = least_squares(
        residual,
        np.zeros(len(prior)),
        jacobian,
        method="lm",
        x_scale=1.0,
        xtol=_TOLERANCE,
        ftol=_TOLERANCE,
        gtol=_TOLERANCE,
    )
    theta = problem.full(found.x)
    model = problem.model.moved(theta)
    closed = close_at(model, poses, problem.guess)
    if (apart := ~(closed.miss_m < _CLOSED_M)).any():
        raise NoSolutionError(
            "calibrate",
            f"no machine that fits can be assembled at all poses: {poses.place(int(np.argmax(apart)))} is one of "
            f"{np.count_nonzero(apart)}",
            "Leave these poses out; begin with moderate ones, farther from singularities (--next 12 without a FILE).",
        )
    data = problem.data_jacobian(theta, closed.pose)
    covariance = np.zeros((len(theta), len(theta)))
    inverse = np.linalg.inv(data.T @ data + np.diag(prior**2)) * np.outer(problem.scales, problem.scales)
    covariance[np.ix_(problem.is_fitted, problem.is_fitted)] = inverse
    return Identification(
        problem=problem,
        theta=theta,
        covariance=covariance,
        model=model,
        pose=closed.pose,
        residual_m=poses.seen_m - positions(model, closed),
        jacobian=data,
        evaluations=int(found.nfev),
    )


def _prior_rows(problem: Problem) -> FloatArray:
    """Give the weight of what is known of each fitted parameter, in its scale: 1, or 0 for frames and clocks."""
    return np.isfinite(problem.prior_std[problem.is_fitted]).astype(float)


def _left_jacobian(turned: FloatArray) -> FloatArray:
    """Give J of exp(w + dw) = exp(J dw) exp(w) for small rotation vectors w: I + K / 2 + K^2 / 6, K = [w]x. (3, 3)."""
    K = np.cross(np.eye(3), -turned)
    return np.asarray(np.eye(3) + K / 2.0 + K @ K / 6.0)


def pose_modes(found: Identification) -> list[str]:
    """Name the working mode of every pose."""
    joints = found.model.cart_joints(found.problem.poses.encoders(found.model.clocks_s))
    R = rotation(*found.pose[:, 3:].T)
    points = found.pose[:, None, :3] + found.model.platform_points_m @ np.swapaxes(R, 1, 2)
    along = np.column_stack([np.ones(len(PRIMARY)), found.model.directions_rad])
    reach = dot((joints - points)[:, PRIMARY], along)
    return mode_names(np.where(reach < 0.0, -1.0, 1.0))
