"""Which poses to measure next: those that say most about the machine, given what is known of it already.

Greedy D-optimal design: with the covariance S of the parameters and the derivatives J of what is seen at a pose, in
deviations of noise, that pose is worth log det(1 + J S J'), and measured it leaves S - S J' (1 + J S J')^-1 J S.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.calibrate.calibration import Calibration, Setting
from pipeline.calibrate.data.design import MODERATE, random_poses
from pipeline.calibrate.elsewhere import CALIBRATED, predicted_error, seen_by_parameters
from pipeline.calibrate.model.forward import close
from pipeline.calibrate.model.model import Model, configured_model
from pipeline.config import Config
from pipeline.machine.geometry import build_machine
from pipeline.machine.statics import condition_number, statics_matrix
from pipeline.machine.working_modes import mode_names, reach_along_rails

_CANDIDATES, _ELSEWHERE = 600, 200
_SEED = 1
_FRAME_STD = 10.0
"""Stands for knowing nothing of the tracker's frame, in metres and radians."""


@dataclass(frozen=True, eq=False)
class NextPoses:
    """Poses to measure, the most useful first.

    Attributes
    ----------
    q_m : (n, 5)
        What encoders should show.
    pose : (n, 6)
        Where the machine then is, by what is known of it.
    modes : list of str
        Working modes.
    kappa : (n,)
        Condition numbers.
    error_m : (n + 1,)
        Predicted error of a reflector anywhere in the workspace, root mean square, before and after each is measured.
    """

    q_m: FloatArray
    pose: FloatArray
    modes: list[str]
    kappa: FloatArray
    error_m: FloatArray


def first_poses(config: Config, reflectors_m: FloatArray, setting: Setting, count: int) -> NextPoses:
    """Choose poses where nothing was measured yet: moderate ones, where a machine that is off still assembles.

    Raises
    ------
    NoSolutionError
        When the machine has too few such poses.
    """
    model = configured_model(config.machine, reflectors_m)
    parameters = model.parameters
    std = np.where(parameters.is_fitted(setting.fit), parameters.prior_std(setting.prior), 0.0)
    covariance = np.diag(np.where(np.isfinite(std), std, _FRAME_STD) ** 2)
    return _greedy(config, model, covariance, setting.noise_m, (count, MODERATE))


def next_poses(calibration: Calibration, count: int) -> NextPoses:
    """Choose poses that add most to a calibration, now also nearer to singularities, within what routes may have.

    Raises
    ------
    NoSolutionError
        When the machine has too few such poses.
    """
    found, config = calibration.identification, calibration.config
    wanted = count, min(CALIBRATED, config.route.kappa_max)
    return _greedy(config, found.model, found.covariance, calibration.setting.noise_m, wanted)


def _greedy(
    config: Config, model: Model, covariance: FloatArray, noise_m: float, wanted: tuple[int, float]
) -> NextPoses:
    count, kappa_max = wanted
    random, machine = np.random.default_rng(_SEED), build_machine(config.machine)
    where = random_poses(config, max(_CANDIDATES, 2 * count), random, kappa_max)
    q = model.to_encoders(where.q_m)
    J = seen_by_parameters(model, q, where.pose) / noise_m
    elsewhere = random_poses(config, _ELSEWHERE, random, kappa_max)
    everywhere = seen_by_parameters(model, model.to_encoders(elsewhere.q_m), elsewhere.pose)
    chosen: list[int] = []
    errors = [predicted_error(everywhere, covariance)]
    free = np.ones(len(q), dtype=bool)
    for _ in range(count):
        gain = np.linalg.slogdet(np.eye(J.shape[1]) + J @ covariance @ np.swapaxes(J, 1, 2))[1]
        best = int(np.argmax(np.where(free, gain, -np.inf)))
        free[best] = False
        chosen.append(best)
        covariance = _measured(covariance, J[best])
        errors.append(predicted_error(everywhere, covariance))
    pose = where.pose[chosen]
    carts = where.q_m[chosen, :3]
    signs = np.sign(reach_along_rails(machine, pose, carts))
    return NextPoses(
        q_m=q[chosen],
        pose=close(model, q[chosen], pose).pose,
        modes=mode_names(signs),
        kappa=condition_number(statics_matrix(machine, pose, carts)),
        error_m=np.array(errors),
    )


def _measured(covariance: FloatArray, J: FloatArray) -> FloatArray:
    """Give the covariance that is left when a pose with derivatives (m, count) is measured."""
    SJ = covariance @ J.T
    left = covariance - SJ @ np.linalg.solve(np.eye(len(J)) + J @ SJ, SJ.T)
    return np.asarray((left + left.T) / 2.0)
