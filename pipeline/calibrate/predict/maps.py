"""Errors of the machine all over the workspace: as it was configured, and as it is calibrated."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.calibrate.calibration import Calibration
from pipeline.calibrate.data.design import sign_at_start
from pipeline.calibrate.elsewhere import seen_by_parameters
from pipeline.calibrate.estimate.frame import fit_frame
from pipeline.calibrate.identify import Identification, pose_modes
from pipeline.calibrate.model.forward import close, positions
from pipeline.calibrate.model.model import Model
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.limits import admitted, pose_limits
from pipeline.limits.actuators import cart_travel
from pipeline.machine.geometry import MODES, build_machine
from pipeline.machine.kinematics import inverse_kinematics
from pipeline.machine.samples import PoseSamples

_STEP_M = 0.05
_CLOSED_M = 1e-9


@dataclass(frozen=True, eq=False)
class ErrorMap:
    """Errors of reflectors in a working mode, in metres, without tilt in the middle of the rails; NaN out of reach.

    Attributes
    ----------
    mode : str
        LLL ... RRR.
    configured_m : (z, y)
        Distance between where reflectors are on the calibrated machine and on the configured one, in the frame that
        fits it best: root mean square of the reflectors.
    calibrated_m : (z, y)
        Predicted error of the calibrated machine, by its covariance.
    measured_yz_m : (n, 2)
        y and z of the poses that were measured in this mode, whatever their x and tilt.
    """

    mode: str
    configured_m: FloatArray
    calibrated_m: FloatArray
    measured_yz_m: FloatArray


@dataclass(frozen=True, eq=False)
class ErrorMaps:
    """Maps of the working modes that can be used, over y (n,) and z (m,)."""

    y_m: FloatArray
    z_m: FloatArray
    maps: tuple[ErrorMap, ...]


def error_maps(calibration: Calibration) -> ErrorMaps:
    """Map the errors before and after a calibration over the YZ plane, on the branch where task.start is.

    Raises
    ------
    NoSolutionError
        When the machine can be nowhere there without tilt.
    """
    config, found = calibration.config, calibration.identification
    before, machine = _configured(found), build_machine(config.machine)
    reach = float(np.nanmax(machine.lengths_m))
    low, high = machine.rails_m.min(axis=0) - reach, machine.rails_m.max(axis=0) + reach
    y, z = (
        np.arange(np.floor(a / _STEP_M), np.ceil(b / _STEP_M) + 1) * _STEP_M for a, b in zip(low, high, strict=True)
    )
    measured = np.array(pose_modes(found))
    maps = []
    for number, mode in enumerate(MODES):
        rows, q, pose = _usable(config, number, y, z)
        if not rows.size:
            continue
        q = found.model.to_encoders(q)
        image = np.full((2, len(z) * len(y)), np.nan)
        image[:, rows] = _moved(before, found.model, q, pose), _predicted(found, q, pose)
        configured, calibrated = image.reshape(2, len(z), len(y))
        maps.append(ErrorMap(mode, configured, calibrated, found.pose[measured == mode][:, 1:3]))
    if not maps:
        raise NoSolutionError(
            "calibrate",
            "the machine can be nowhere in the middle of its rails without tilt, on the side of task.start",
            "Check the machine's limits (gantry-tau check CONFIG).",
        )
    return ErrorMaps(y, z, tuple(maps))


def _configured(found: Identification) -> Model:
    """Give the configured machine in the frame in which it is nearest to the calibrated one at the measured poses."""
    q, own = found.problem.poses.encoders(found.model.clocks_s), found.problem.model.with_frame(np.eye(3), np.zeros(3))
    points, target = (positions(model, close(model, q, found.pose)) for model in (own, found.model))
    frame = fit_frame(points.reshape(-1, 3), target.reshape(-1, 3))
    return own.with_frame(frame.rotation, frame.translation_m)


def _moved(before: Model, after: Model, q_m: FloatArray, pose: FloatArray) -> FloatArray:
    """Compute the distance between reflectors of two machines, root mean square over them. Shape (n,)."""
    one, other = close(before, q_m, pose), close(after, q_m, pose)
    off = np.linalg.norm(positions(before, one) - positions(after, other), axis=2)
    is_closed = np.maximum(one.miss_m, other.miss_m) < _CLOSED_M
    return np.where(is_closed, np.sqrt((off**2).mean(axis=1)), np.nan)


def _predicted(found: Identification, q_m: FloatArray, pose: FloatArray) -> FloatArray:
    """Predict the error of reflectors, root mean square over them. Shape (n,)."""
    J = seen_by_parameters(found.model, q_m, pose)
    variance = np.sum((J @ found.covariance) * J, axis=2)
    return np.asarray(np.sqrt(3.0 * variance.mean(axis=1)))


def _usable(config: Config, mode: int, y_m: FloatArray, z_m: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Find the cells where the machine can be within its limits on its branch: their numbers, actuators and poses."""
    machine = build_machine(config.machine)
    Z, Y = np.meshgrid(z_m, y_m, indexing="ij")
    controlled = np.zeros((Z.size, 5))
    controlled[:, 0] = machine.travel_m.mean()
    controlled[:, 1], controlled[:, 2] = Y.ravel(), Z.ravel()
    found = inverse_kinematics(machine, controlled, np.full(Z.size, mode))
    rows = np.flatnonzero(found.reachable)
    samples = PoseSamples(machine, found.pose[rows], found.q_m[rows])
    kept, samples = admitted([cart_travel(machine), *pose_limits(machine, config.route.kappa_max)], samples)
    rows = rows[kept[samples.det_sign == sign_at_start(config, machine)]]
    return rows, found.q_m[rows], found.pose[rows]
