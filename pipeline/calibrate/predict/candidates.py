"""Poses that may be measured, and what they would say: greedy D-optimal design.

With the covariance S of the parameters and the derivatives J of what is seen at a pose, in deviations of noise, that
pose is worth log det(1 + J S J'), and measured it leaves S - S J' (1 + J S J')^-1 J S.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.calibrate.calibration import Setting
from pipeline.calibrate.data.design import random_poses
from pipeline.calibrate.elsewhere import CALIBRATED, predicted_error, seen_by_parameters
from pipeline.calibrate.model.model import Model
from pipeline.config import Config

_CANDIDATES, _ELSEWHERE = 600, 200
_SEED = 1
_FRAME_STD = 10.0
"""Stands for knowing nothing of the tracker's frame, in metres and radians."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Poses at random to choose from, and others at which errors are predicted.

    Attributes
    ----------
    q_m : (n, 5)
        What encoders should show.
    pose : (n, 6)
        Where the configured machine then is, and
    carts_m : (n, 3)
        where its carts are.
    seen : (n, 3 reflectors, count)
        Derivatives of what is seen by all parameters, in deviations of noise.
    elsewhere_m : (k, 3 reflectors, count)
        The same at other poses, in metres.
    """

    q_m: FloatArray
    pose: FloatArray
    carts_m: FloatArray
    seen: FloatArray
    elsewhere_m: FloatArray

    def error_m(self, covariance: FloatArray) -> float:
        """Predict the error of a reflector anywhere, root mean square. Three coordinates make one reflector."""
        return predicted_error(self.elsewhere_m, covariance)


def draw_candidates(config: Config, model: Model, noise_m: float, wanted: tuple[int, float]) -> Candidates:
    """Draw poses of a machine, enough for a number of them to be chosen, with kappa up to a largest one.

    Raises
    ------
    NoSolutionError
        When the machine has too few such poses.
    """
    count, kappa_max = wanted
    random = np.random.default_rng(_SEED)
    where = random_poses(config, max(_CANDIDATES, 2 * count), random, kappa_max)
    elsewhere = random_poses(config, _ELSEWHERE, random, kappa_max)
    q = model.to_encoders(where.q_m)
    return Candidates(
        q_m=q,
        pose=where.pose,
        carts_m=where.q_m[:, :3],
        seen=seen_by_parameters(model, q, where.pose) / noise_m,
        elsewhere_m=seen_by_parameters(model, model.to_encoders(elsewhere.q_m), elsewhere.pose),
    )


def largest_kappa(config: Config) -> float:
    """Give the largest kappa of poses to measure once a machine is calibrated."""
    return min(CALIBRATED, config.route.kappa_max)


def known_beforehand(model: Model, setting: Setting) -> FloatArray:
    """Give the covariance of all parameters where nothing was measured. Shape (count, count)."""
    parameters = model.parameters
    std = np.where(parameters.is_fitted(setting.fit), parameters.prior_std(setting.prior), 0.0)
    return np.diag(np.where(np.isfinite(std), std, _FRAME_STD) ** 2)


def choose(among: Candidates, covariance: FloatArray, count: int) -> tuple[IntArray, FloatArray]:
    """Choose poses one by one, each worth most with those before; with errors before and after each. (n,), (n + 1,)."""
    chosen, errors = [], [among.error_m(covariance)]
    J, free = among.seen, np.ones(len(among.seen), dtype=bool)
    for _ in range(count):
        gain = np.linalg.slogdet(np.eye(J.shape[1]) + J @ covariance @ np.swapaxes(J, 1, 2))[1]
        best = int(np.argmax(np.where(free, gain, -np.inf)))
        free[best] = False
        chosen.append(best)
        covariance = measured(covariance, J[best])
        errors.append(among.error_m(covariance))
    return np.array(chosen, dtype=int), np.array(errors)


def measured(covariance: FloatArray, J: FloatArray) -> FloatArray:
    """Give the covariance that is left when coordinates with derivatives (m, count) are measured."""
    SJ = covariance @ J.T
    left = covariance - SJ @ np.linalg.solve(np.eye(len(J)) + J @ SJ, SJ.T)
    return np.asarray((left + left.T) / 2.0)
