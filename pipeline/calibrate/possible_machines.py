"""The machines that a calibration leaves possible, about the machine of a run.

Its covariance contains what no reflector can tell. As far as that is a mere choice of frames, of the machine against
the tracker and of the platform against the reflectors, it says nothing of the machine, and is settled by definition:
each machine is written down in those frames in which its closures along the path differ least from those of the
calibrated one, in the mean of squares, and its parameters differ least as far as these cannot tell. With theta all
parameters but the tracker's in units of what was known beforehand, columns N for changes of frames, and rows F of the
closures |p + R a_l - C_l| - len_l = 0 along the path, differentiated by theta, and of 3 um times theta, that is

    theta - N y,  y = argmin |F (theta - N y)|,  so that S becomes P S P',  P = 1 - N (N' F' F N)^-1 N' F' F,

of which the rows of the machine are kept, and those of reflectors are not. All else that reflectors cannot tell stays
as uncertain as it was beforehand: rails against the joints on their carts, and joints 3a and 3c along their line, as
they change distances and kappa.
"""

import numpy as np
from scipy.stats import chi2

from pipeline.arrays import FloatArray
from pipeline.calibrate.model.forward import by_parameters, close
from pipeline.calibrate.model.gauges import fitted_frames
from pipeline.calibrate.model.model import Model
from pipeline.calibrate.stored import StoredCalibration, require_calibrated
from pipeline.config import MachineConfig
from pipeline.inclusion.calibrated.ellipsoid import PARAMETERS, Ellipsoid
from pipeline.refine.result import Path

_RANK = 1e-9
"""Deviations below this part of the largest, in units of what was known beforehand, are zero."""
_SAMPLES = 101
_WEIGHT_M = 3e-6
"""What a parameter that differs by as much as was known beforehand counts like, as a closure."""


def possible_machines(stored: StoredCalibration, machine: MachineConfig, path: Path, sigma: float) -> Ellipsoid:
    """Give all machines within `sigma` standard deviations, of every combination of parameters, of a calibrated one.

    Raises
    ------
    UsageError
        When the machine is not the calibrated one.
    """
    model = require_calibrated(stored, machine)
    units = stored.prior_std[:PARAMETERS, None]
    values, vectors = np.linalg.eigh(machine_covariance(stored, model, path) / (units * units.T))
    kept = np.sqrt(np.maximum(values, 0.0)) > _RANK * np.sqrt(values[-1])
    factor = units * vectors[:, kept] * np.sqrt(values[kept])
    return Ellipsoid(factor, sigma, model.middles_m + model.zeros_m, model.scales)


def machine_covariance(stored: StoredCalibration, model: Model, path: Path) -> FloatArray:
    """Compute the covariance of a machine's parameters in its own frames, (56, 56)."""
    parameters, kept = stored.parameters, stored.is_fitted & np.isfinite(stored.prior_std)
    units = stored.prior_std[kept]
    s = np.linspace(0.0, 1.0, _SAMPLES)
    q_m = model.to_encoders(path.q(s))
    F = by_parameters(model, q_m, close(model, q_m, path.pose(s)))[..., kept].reshape(-1, len(units)) * units
    F = np.vstack([F / np.sqrt(len(F)), _WEIGHT_M * np.eye(len(units))])
    N = (fitted_frames(model, stored.is_fitted)[:, kept] / units).T
    project = np.eye(len(units)) - N @ np.linalg.lstsq(F @ N, F)[0]
    S = stored.covariance[np.ix_(kept, kept)] / np.outer(units, units)
    whole = np.zeros((parameters.count, parameters.count))
    whole[np.ix_(kept, kept)] = (project @ S @ project.T) * np.outer(units, units)
    return whole[:PARAMETERS, :PARAMETERS]


def probability_within(ellipsoid: Ellipsoid) -> float:
    """Give the probability that all parameters together are within the ellipsoid: chi-square of its dimensions."""
    return float(chi2.cdf(ellipsoid.sigma**2, ellipsoid.factor.shape[1]))


def sigma_of(probability: float, dimensions: int) -> float:
    """Give the number of deviations within which all parameters together are with some probability."""
    return float(np.sqrt(chi2.ppf(probability, dimensions)))
