"""How sure a calibration is along the motions it was made from, and elsewhere in the workspace."""

from typing import NamedTuple

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.calibrate.data.design import random_poses
from pipeline.calibrate.identify import Identification
from pipeline.calibrate.model.forward import close, position_jacobian
from pipeline.calibrate.model.model import Model
from pipeline.config import Config

CALIBRATED = 40.0
"""Largest kappa of poses once a machine is known to a few tenths of a millimetre."""
_ELSEWHERE, _SEED = 200, 2


class Reach(NamedTuple):
    """Predicted errors of a reflector, root mean square: along the motions that were measured, and elsewhere."""

    along_m: float
    elsewhere_m: float


def predicted_reach(config: Config, found: Identification) -> Reach:
    """Predict errors by the covariance, noise left out.

    Raises
    ------
    NoSolutionError
        When the machine has too few poses elsewhere.
    """
    moving = np.flatnonzero(found.problem.poses.is_moving)
    variance = found.predicted_covariance(found.problem.poses.at(moving), found.pose[moving])
    along = float(np.sqrt(np.trace(variance, axis1=2, axis2=3).mean()))
    kappa_max = min(CALIBRATED, config.route.kappa_max)
    where = random_poses(config, _ELSEWHERE, np.random.default_rng(_SEED), kappa_max)
    everywhere = seen_by_parameters(found.model, found.model.to_encoders(where.q_m), where.pose)
    return Reach(along, predicted_error(everywhere, found.covariance))


def seen_by_parameters(model: Model, q_m: FloatArray, pose: FloatArray) -> FloatArray:
    """Differentiate all coordinates seen at every static pose by all parameters. Shape (n, 3 reflectors, count)."""
    J = position_jacobian(model, q_m, close(model, q_m, pose))
    return J.reshape(len(J), -1, J.shape[-1])


def predicted_error(J: FloatArray, covariance: FloatArray) -> float:
    """Predict the error of a reflector, root mean square over poses. Three coordinates make one reflector."""
    rows = J.reshape(-1, J.shape[-1])
    return float(np.sqrt(3.0 * np.sum((rows @ covariance) * rows) / len(rows)))
