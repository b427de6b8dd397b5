"""A calibration: the machine identified from some poses, checked with others, and whether it may be believed."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from pipeline.arguments import require_number
from pipeline.arrays import BoolArray, FloatArray
from pipeline.calibrate.data.poses import StaticPoses
from pipeline.calibrate.data.seen import close_at
from pipeline.calibrate.elsewhere import Reach, predicted_reach
from pipeline.calibrate.estimate.clocks import first_clocks
from pipeline.calibrate.estimate.frame import fit_frame
from pipeline.calibrate.estimate.start import start
from pipeline.calibrate.identify import Identification, Problem, identify
from pipeline.calibrate.model.forward import positions
from pipeline.calibrate.model.model import Model, configured_model
from pipeline.calibrate.model.parameters import CLOCKS, USUAL
from pipeline.calibrate.robust import identify_robustly, most_deviations
from pipeline.config import Config
from pipeline.errors import UsageError

_SEED = 0
_LEAST_POSES = 3


@dataclass(frozen=True)
class Setting:
    """How a machine is calibrated.

    Attributes
    ----------
    noise_m : float
        Standard deviation of every measured coordinate.
    fit : tuple of str
        Kinds of parameters that may change, of `parameters.CHOICES`.
    prior : mapping of str to float
        Standard deviations of what is known of kinds beforehand, where they are not the usual ones.
    robust : bool
        Reject outliers.
    hold_out : float
        Part of the poses that is kept for checking.

    Raises
    ------
    ArgumentError
        When a number is not positive, or more than 0.9 is held out.
    """

    noise_m: float = 5e-5
    fit: tuple[str, ...] = USUAL
    prior: Mapping[str, float] = field(default_factory=dict)
    robust: bool = False
    hold_out: float = 0.0

    def __post_init__(self) -> None:
        require_number("noise_m", self.noise_m, above=0.0)
        require_number("hold_out", self.hold_out, least=0.0, largest=0.9)
        for key, std in self.prior.items():
            require_number(f"prior {key}", std, above=0.0)


@dataclass(frozen=True, eq=False)
class Check:
    """How far points are from where a machine has them, in metres: root mean squares of distances.

    Attributes
    ----------
    points, rejected : int
        Number of points, and of others that were left out as outliers.
    before_m : float
        Of the configured machine, in the frame of the tracker that fits it best.
    after_m : float
        Of the calibrated machine.
    predicted_m : float
        What `after_m` should be, by covariance and noise.
    """

    points: int
    rejected: int
    before_m: float
    after_m: float
    predicted_m: float


@dataclass(frozen=True, eq=False)
class Calibration:
    """A calibrated machine.

    Attributes
    ----------
    config : Config
        The machine as configured.
    setting : Setting
        How it was calibrated.
    identification : Identification
        The machine that was found, from the poses that were not held out.
    rejected : (n, reflectors)
        Points of these poses that were left out as outliers.
    fitted : Check
        Errors at these poses.
    held_out : Check or None
        Errors at the poses that took no part.
    reach : Reach or None
        Predicted errors along motions and elsewhere; None where there are no motions.
    """

    config: Config
    setting: Setting
    identification: Identification
    rejected: BoolArray
    fitted: Check
    held_out: Check | None
    reach: Reach | None = None


def calibrate(config: Config, reflectors_m: FloatArray, poses: StaticPoses, setting: Setting) -> Calibration:
    """Identify the machine that explains measured poses.

    Raises
    ------
    UsageError
        When there are too few poses, or data that are not of this machine, see `start.start`.
    """
    poses = poses.at(np.flatnonzero(poses.is_seen.any(axis=1)))
    if len(poses) < _LEAST_POSES:
        raise UsageError(
            f"{len(poses)} poses with a reflector are too few: a calibration needs {_LEAST_POSES} for the frame of the "
            "tracker alone, and some 15 for a machine"
        )
    configured = configured_model(config.machine, reflectors_m)
    clocks_s = first_clocks(configured, poses) if CLOCKS.key in setting.fit else np.zeros(poses.motions)
    model, guess = start(config, configured.with_clocks(clocks_s), poses)
    is_kept = _kept(len(poses), setting.hold_out)
    kept, held = np.flatnonzero(is_kept), np.flatnonzero(~is_kept)
    problem = build_problem(model, poses.at(kept), guess[kept], setting)
    if setting.robust:
        found, rejected = identify_robustly(problem)
    else:
        found, rejected = identify(problem), np.zeros_like(problem.poses.is_seen)
    frame = _best_frame(found)
    return Calibration(
        config=config,
        setting=setting,
        identification=found,
        rejected=rejected,
        fitted=_check_fitted(found, frame, int(rejected.sum())),
        reach=predicted_reach(config, found) if poses.motions else None,
        held_out=_check_held_out(found, frame, poses.at(held), guess[held], setting.robust) if held.size else None,
    )


def build_problem(model: Model, poses: StaticPoses, guess: FloatArray, setting: Setting) -> Problem:
    """Pose the identification of a machine, from the configured one in a first frame of the tracker."""
    parameters = model.parameters
    return Problem(
        model=model,
        poses=poses,
        guess=guess,
        noise_m=setting.noise_m,
        prior_std=parameters.prior_std(setting.prior),
        is_fitted=parameters.is_fitted(setting.fit),
        weights=np.ones(poses.is_seen.shape),
    )


def _kept(count: int, hold_out: float) -> BoolArray:
    """Choose the poses to fit: at random, and the same ones for the same number of poses."""
    kept = np.ones(count, dtype=bool)
    held = min(round(hold_out * count), count - _LEAST_POSES)
    kept[np.random.default_rng(_SEED).permutation(count)[:held]] = False
    return kept


def _best_frame(found: Identification) -> Model:
    """Give the configured machine in the frame in which it fits the data best."""
    problem, seen = found.problem, found.problem.poses.is_seen
    own = problem.model.with_frame(np.eye(3), np.zeros(3))
    points = positions(own, close_at(own, problem.poses, problem.guess))
    frame = fit_frame(points[seen], problem.poses.seen_m[seen])
    return own.with_frame(frame.rotation, frame.translation_m)


def _check_fitted(found: Identification, before: Model, rejected: int) -> Check:
    problem = found.problem
    count = int(problem.poses.is_seen.sum())
    predicted = problem.noise_m * np.sqrt(found.data_freedom / count)
    before_m, after_m = (_rms(_off(model, problem.poses, problem.guess)) for model in (before, found.model))
    return Check(count, rejected, before_m, after_m, float(predicted))


def _check_held_out(
    found: Identification, before: Model, poses: StaticPoses, guess: FloatArray, robust: bool
) -> Check | None:
    """Compare poses that took no part; of a robust fit, outliers are left out here as well."""
    seen, noise = poses.is_seen, found.problem.noise_m
    variance = 3.0 * noise**2 + np.trace(found.predicted_covariance(poses, guess), axis1=2, axis2=3)
    off = _off(found.model, poses, guess)
    far = off > most_deviations(int(seen.sum())) * np.sqrt(variance) if robust else np.zeros_like(seen)
    kept = seen & ~far
    if not kept.any():
        return None
    before_m = _rms(_off(before, poses, guess)[kept])
    predicted = float(np.sqrt(variance[kept].mean()))
    return Check(int(kept.sum()), int((seen & far).sum()), before_m, _rms(off[kept]), predicted)


def _off(model: Model, poses: StaticPoses, guess: FloatArray) -> FloatArray:
    """Give the distances of points from where a machine has them; NaN where unseen. Shape (n, reflectors)."""
    points = positions(model, close_at(model, poses, guess))
    return np.asarray(np.linalg.norm(poses.seen_m - points, axis=2))


def _rms(distances_m: FloatArray) -> float:
    return float(np.sqrt(np.nanmean(distances_m**2)))
