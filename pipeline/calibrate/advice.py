"""Advice for a calibration that is refused, tried before it is given: with it, the calibration would be accepted."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipeline.calibrate.calibration import Calibration
from pipeline.calibrate.elsewhere import seen_by_parameters
from pipeline.calibrate.identify import Identification, Problem, identify
from pipeline.calibrate.model.gauges import rank
from pipeline.calibrate.model.parameters import KINDS
from pipeline.calibrate.next_poses import next_poses
from pipeline.errors import NoSolutionError

Believed = Callable[[Identification], bool]
_LENGTHS = tuple(kind.key for kind in KINDS if kind.unit == "m")
_PRIORS_M = (3e-4, 5e-4, 1e-3, 2e-3, 5e-3)
_POSES = (4, 8, 12, 16, 24)


def enough_poses(calibration: Calibration, needed: int) -> int | None:
    """How many of the next-best poses determine what those measured do not; None if none of the numbers tried do."""
    found = calibration.identification
    problem = found.problem
    measured = problem.data_jacobian(np.zeros_like(found.theta), problem.guess)
    try:
        proposed = next_poses(calibration, max(_POSES))
    except NoSolutionError:
        return None
    J = seen_by_parameters(found.model, proposed.q_m, proposed.pose)[..., problem.is_fitted]
    J *= problem.scales / problem.noise_m
    for count in _POSES:
        if rank(np.vstack([measured, J[:count].reshape(-1, J.shape[-1])])) >= needed:
            return count
    return None


def larger_prior(problem: Problem, is_believed: Believed) -> float | None:
    """Find a deviation of lengths known beforehand (`--prior`) with which the machine is believed; None if none is."""
    parameters = problem.model.parameters
    is_length = parameters.is_fitted(_LENGTHS) & np.isfinite(problem.prior_std)
    for std in _PRIORS_M:
        wider = np.where(is_length, np.maximum(problem.prior_std, std), problem.prior_std)
        if is_believed(identify(replace(problem, prior_std=wider))):
            return std
    return None


def larger_noise(found: Identification, is_believed: Believed) -> float | None:
    """Find the noise (`--noise`), in whole micrometres, with which the machine is believed; None if it is not then."""
    problem = found.problem
    noise_m = problem.noise_m * np.sqrt(found.data_chi2 / found.data_freedom)
    rounded = float(np.ceil(1e6 * noise_m) / 1e6)
    return rounded if is_believed(identify(replace(problem, noise_m=rounded))) else None
