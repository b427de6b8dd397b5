"""Simulated measurements: static poses or a motion of a machine as real ones are, seen by a tracker in the room."""

from dataclasses import dataclass, replace
from typing import NamedTuple
from zlib import crc32

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.arguments import require_number, require_whole
from pipeline.arrays import BoolArray, FloatArray
from pipeline.calibrate.data.design import MODERATE, random_poses
from pipeline.calibrate.data.motions import DrivenMotion
from pipeline.calibrate.data.poses import StaticPoses, Timing
from pipeline.calibrate.data.reading import reflector_columns
from pipeline.calibrate.data.seen import close_at
from pipeline.calibrate.model import parameters as kinds
from pipeline.calibrate.model.forward import Closed, positions
from pipeline.calibrate.model.model import Model, configured_model
from pipeline.calibrate.model.parameters import Kind
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.export.trajectory_columns import POSITIONS
from pipeline.machine.kinematics import InverseSolution
from pipeline.measured.perturbed import generators
from pipeline.measured.table import TIME
from pipeline.measured.tracker import with_outliers

_FARTHEST_M = 4.0
"""How far, along each axis, the tracker is away at most."""
_CLOSED_M = 1e-9


@dataclass(frozen=True)
class StaticSetting:
    """How far a machine is from its configuration, and how it is measured; deviations are normally distributed.

    Attributes
    ----------
    poses : int
        Number of poses.
    geometry_std_m : float
        Of every coordinate of every joint, rail and reflector, of lengths and of zeros of encoders.
    scale_std : float
        Of the scale of every encoder.
    direction_std_rad : float
        Of the slopes of rails.
    noise_m : float
        Of every measured coordinate.
    outliers : float
        Part of the points that are 50 mm off.
    seed : int
        The same seed gives the same measurement.

    Raises
    ------
    ArgumentError
        When a number is negative, or outliers are more than half.
    """

    poses: int = 40
    geometry_std_m: float = 2e-4
    scale_std: float = 1e-4
    direction_std_rad: float = 0.0
    noise_m: float = 5e-5
    outliers: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        require_whole("poses", self.poses, 1, 100_000)
        for name in ("geometry_std_m", "scale_std", "direction_std_rad", "noise_m"):
            require_number(name, getattr(self, name), least=0.0)
        require_number("outliers", self.outliers, least=0.0, largest=0.5)
        require_whole("seed", self.seed, 0, 2**53)


@dataclass(frozen=True, eq=False)
class SimulatedPoses:
    """A simulated measurement, and the truth behind it.

    Attributes
    ----------
    poses : StaticPoses
        What was measured.
    configured_pose : (n, 6)
        Where the configured machine would be.
    truth : Model
        The machine that was measured, in the frame of the tracker.
    is_outlier : (n, reflectors)
        Points that are far off.
    noise_m : float
        Standard deviation of every measured coordinate.
    """

    poses: StaticPoses
    configured_pose: FloatArray
    truth: Model
    is_outlier: BoolArray
    noise_m: float

    def measure(self, q_m: FloatArray, near: FloatArray) -> StaticPoses:
        """Measure the same machine with encoders (n, 5) at other poses, near those given (n, 6), without outliers.

        The same encoders are measured with the same noise, others with other noise.

        Raises
        ------
        NoSolutionError
            When it cannot be assembled at one.
        """
        poses = StaticPoses(q_m, np.full((len(q_m), *self.poses.seen_m.shape[1:]), np.nan))
        seen = positions(self.truth, _assembled(self.truth, poses, near))
        noise = np.random.default_rng(crc32(np.ascontiguousarray(q_m).tobytes()))
        return replace(poses, seen_m=seen + noise.normal(0.0, self.noise_m, seen.shape))


def simulate_static(config: Config, reflectors_m: FloatArray, setting: StaticSetting) -> SimulatedPoses:
    """Measure moderate poses, in all working modes that can be had, of a machine that is a little off.

    Raises
    ------
    NoSolutionError
        When there are not enough such poses, or the machine that was drawn cannot be assembled at one.
    """
    drawn = _draw(config, reflectors_m, setting)
    unseen = np.full((setting.poses, len(reflectors_m), 3), np.nan)
    poses = StaticPoses(drawn.configured.to_encoders(drawn.where.q_m), unseen)
    return _measured(drawn, poses, drawn.where.pose, drawn.truth, setting)


def simulate_motion(
    config: Config, reflectors_m: FloatArray, driven: DrivenMotion, setting: StaticSetting, late_s: float = 0.0
) -> SimulatedPoses:
    """Measure a motion, once per period, of the machine that static poses of the same setting are of.

    The clock of the tracker is late by `late_s`.

    Raises
    ------
    NoSolutionError
        When the machine that was drawn cannot be assembled somewhere along the motion.
    """
    drawn = _draw(config, reflectors_m, setting)
    t = np.arange(0.0, driven.trajectory.duration_s + driven.period_s / 2.0, driven.period_s)
    timing = Timing(driven, np.zeros(len(t), dtype=int), t)
    seen = np.full((len(t), len(reflectors_m), 3), np.nan)
    poses = StaticPoses(driven.encoders(t), seen, timing=timing)
    late = np.array([late_s])
    return _measured(drawn, poses, driven.pose(poses.times_s(late)), drawn.truth.with_clocks(late), setting)


class _Drawn(NamedTuple):
    """A machine that was drawn, in the frame of its tracker, where it is measured, and noise that is yet to be."""

    configured: Model
    truth: Model
    where: InverseSolution
    noise: np.random.Generator


def _draw(config: Config, reflectors_m: FloatArray, setting: StaticSetting) -> _Drawn:
    geometry, noise = generators(setting.seed)
    model = configured_model(config.machine, reflectors_m)
    where = random_poses(config, setting.poses, geometry, MODERATE)
    truth = model.moved(_deviations(model, setting, geometry)).with_frame(
        Rotation.random(random_state=geometry).as_matrix(), geometry.uniform(-_FARTHEST_M, _FARTHEST_M, 3)
    )
    return _Drawn(model, truth, where, noise)


def _measured(
    drawn: _Drawn, poses: StaticPoses, guess: FloatArray, truth: Model, setting: StaticSetting
) -> SimulatedPoses:
    """See the reflectors of a machine at all rows, with noise and outliers."""
    seen = positions(truth, _assembled(truth, poses, guess))
    noise = drawn.noise.normal(0.0, setting.noise_m, seen.shape)
    seen, is_outlier = with_outliers(seen + noise, setting.outliers, drawn.noise)
    return SimulatedPoses(replace(poses, seen_m=seen), guess, truth, is_outlier, setting.noise_m)


def _assembled(truth: Model, poses: StaticPoses, guess: FloatArray) -> Closed:
    closed = close_at(truth, poses, guess)
    if not (closed.miss_m <= _CLOSED_M).all():
        raise NoSolutionError(
            "simulate-measurement",
            "the machine that was drawn cannot be assembled at a pose that was to be measured",
            "Ask for smaller deviations (--geometry), or another seed.",
        )
    return closed


def static_columns(poses: StaticPoses) -> dict[str, FloatArray]:
    """Name the columns of static poses, or of one motion, as `read_poses` reads them."""
    columns = {TIME: poses.timing.t_s} if poses.timing is not None else dict(zip(POSITIONS, poses.q_m.T, strict=True))
    for number in range(poses.seen_m.shape[1]):
        columns |= dict(zip(reflector_columns(number + 1), poses.seen_m[:, number].T, strict=True))
    return columns


def _deviations(model: Model, setting: StaticSetting, random: np.random.Generator) -> FloatArray:
    """Draw deviations of all parameters but the tracker's. Shape (count,)."""

    def std(kind: Kind) -> float:
        own = {kinds.SCALES: setting.scale_std, kinds.DIRECTIONS: setting.direction_std_rad, kinds.TRACKER: 0.0}
        return own.get(kind, setting.geometry_std_m)

    parameters = model.parameters
    theta = random.normal(size=parameters.count)
    for kind in kinds.KINDS:
        theta[parameters.slice(kind)] *= std(kind)
    return theta
