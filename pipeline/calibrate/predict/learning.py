"""How errors fall with the number of poses: as they were measured, at random, and the most useful ones."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.calibrate.calibration import Calibration
from pipeline.calibrate.data.seen import close_at, seen_jacobian
from pipeline.calibrate.predict.candidates import (
    Candidates,
    choose,
    draw_candidates,
    known_beforehand,
    largest_kappa,
    measured,
)

_DRAWS = 8
_SEED = 2


@dataclass(frozen=True, eq=False)
class Learning:
    """Predicted errors of a reflector anywhere, root mean square in metres, by the number of poses measured.

    Attributes
    ----------
    measured_m : (n + 1,)
        With the first 0 ... n poses of the calibration.
    further_m : (k + 1,)
        With all n of them and 0 ... k of those that add most.
    best_m : (n + k + 1,)
        With poses that were all chosen to add most.
    random_m : (draws, n + k + 1)
        With poses at random.
    """

    measured_m: FloatArray
    further_m: FloatArray
    best_m: FloatArray
    random_m: FloatArray


def learning_curves(calibration: Calibration, further: int = 20) -> Learning:
    """Predict errors for all numbers of poses up to those of a calibration and so many more.

    Raises
    ------
    NoSolutionError
        When the machine has too few poses to choose from.
    """
    found, noise_m = calibration.identification, calibration.setting.noise_m
    poses, model = found.problem.poses, found.model
    total = len(poses) + further
    among = draw_candidates(calibration.config, model, noise_m, (total, largest_kappa(calibration.config)))
    beforehand = known_beforehand(model, calibration.setting)
    seen = np.repeat(poses.is_seen, 3, axis=1)
    J = seen_jacobian(model, poses, close_at(model, poses, found.pose)).reshape(len(poses), -1, model.parameters.count)
    random = np.random.default_rng(_SEED)
    draws = [random.choice(len(among.seen), total, replace=False) for _ in range(_DRAWS)]
    return Learning(
        measured_m=_errors(among, beforehand, [rows[known] / noise_m for rows, known in zip(J, seen, strict=True)]),
        further_m=choose(among, found.covariance, further)[1],
        best_m=choose(among, beforehand, total)[1],
        random_m=np.array([_errors(among, beforehand, list(among.seen[rows])) for rows in draws]),
    )


def _errors(among: Candidates, covariance: FloatArray, poses: list[FloatArray]) -> FloatArray:
    """Predict errors before and after each of some poses, given by their derivatives. Shape (n + 1,)."""
    errors = [among.error_m(covariance)]
    for J in poses:
        covariance = measured(covariance, J)
        errors.append(among.error_m(covariance))
    return np.array(errors)
