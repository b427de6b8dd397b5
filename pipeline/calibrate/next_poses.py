"""Which poses to measure next: those that say most about the machine, given what is known of it already."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.calibrate.calibration import Calibration, Setting
from pipeline.calibrate.data.design import MODERATE
from pipeline.calibrate.model.forward import close
from pipeline.calibrate.model.model import Model, configured_model
from pipeline.calibrate.predict.candidates import Candidates, choose, draw_candidates, known_beforehand, largest_kappa
from pipeline.config import Config
from pipeline.machine.geometry import build_machine
from pipeline.machine.statics import condition_number, statics_matrix
from pipeline.machine.working_modes import mode_names, reach_along_rails


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
    among = draw_candidates(config, model, setting.noise_m, (count, MODERATE))
    return _chosen(config, model, among, known_beforehand(model, setting), count)


def next_poses(calibration: Calibration, count: int) -> NextPoses:
    """Choose poses that add most to a calibration, now also nearer to singularities, within what routes may have.

    Raises
    ------
    NoSolutionError
        When the machine has too few such poses.
    """
    found, config = calibration.identification, calibration.config
    among = draw_candidates(config, found.model, calibration.setting.noise_m, (count, largest_kappa(config)))
    return _chosen(config, found.model, among, found.covariance, count)


def _chosen(config: Config, model: Model, among: Candidates, covariance: FloatArray, count: int) -> NextPoses:
    machine, (rows, errors) = build_machine(config.machine), choose(among, covariance, count)
    pose, carts, q = among.pose[rows], among.carts_m[rows], among.q_m[rows]
    return NextPoses(
        q_m=q,
        pose=close(model, q, pose).pose,
        modes=mode_names(np.sign(reach_along_rails(machine, pose, carts))),
        kappa=condition_number(statics_matrix(machine, pose, carts)),
        error_m=errors,
    )
