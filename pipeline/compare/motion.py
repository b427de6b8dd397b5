"""Motions along paths that are timed in the same way: duration, and peaks of acceleration and jerk."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config, RetimeConfig
from pipeline.errors import NoSolutionError
from pipeline.refine.result import Path
from pipeline.retime import MotionQuality, Trajectory, measure_quality, retime_path

_INSTANTS = 4_001
_CARTS, _TELESCOPES = slice(0, 3), slice(3, 5)


@dataclass(frozen=True)
class MotionFigures:
    """A trajectory in numbers; peaks are the largest absolute values of any cart or telescope.

    Attributes
    ----------
    duration_s : float
        Time from rest to rest.
    cart_acceleration_mps2, telescope_acceleration_mps2 : float
        Peaks of acceleration.
    cart_jerk_mps3, telescope_jerk_mps3 : float
        Peaks of jerk; infinite where accelerations jump.
    quality : MotionQuality or None
        Sign changes, and the duration against the least one; None at a duration that the motion was not planned for.
    """

    duration_s: float
    cart_acceleration_mps2: float
    telescope_acceleration_mps2: float
    cart_jerk_mps3: float
    telescope_jerk_mps3: float
    quality: MotionQuality | None = None


def common_retiming(config: Config) -> RetimeConfig:
    """Select the settings with which all paths are timed: the configuration's, at full speed and without waiting."""
    return config.retime.model_copy(update={"speed": 1.0, "dwell_s": (0.0, 0.0)})


def retimed(
    config: Config,
    retiming: RetimeConfig,
    path: Path,
    retime: Callable[[Config, Path], Trajectory] = retime_path,
) -> Trajectory:
    """Time a path within the limits of its own machine; if that fails with limited jerk, again with twice the pieces.

    Raises
    ------
    NoSolutionError
        When the path cannot be timed within them.
    """
    try:
        return retime(config.model_copy(update={"retime": retiming}), path)
    except NoSolutionError:
        if not retiming.jerk:
            raise
    finer = retiming.model_copy(update={"jerk_pieces": 2 * retiming.jerk_pieces})
    return retime(config.model_copy(update={"retime": finer}), path)


def measure_motion(trajectory: Trajectory) -> MotionFigures:
    """Reduce a trajectory to figures, evaluated at evenly spaced instants."""
    t = np.linspace(0.0, trajectory.duration_s, _INSTANTS)
    acceleration = _peaks(trajectory.q(t, 2))
    jerk = (np.inf, np.inf) if trajectory.jerk_jumps else _peaks(trajectory.q(t, 3))
    return MotionFigures(trajectory.motion_s, *acceleration, *jerk, measure_quality(trajectory))


def at_duration(figures: MotionFigures, duration_s: float) -> MotionFigures:
    """Scale figures to another duration of the same motion.

    With f = duration / old duration, accelerations are divided by f^2 and jerks by f^3.
    """
    f = duration_s / figures.duration_s
    return MotionFigures(
        duration_s,
        figures.cart_acceleration_mps2 / f**2,
        figures.telescope_acceleration_mps2 / f**2,
        figures.cart_jerk_mps3 / f**3,
        figures.telescope_jerk_mps3 / f**3,
    )


def _peaks(values: FloatArray) -> tuple[float, float]:
    size = np.abs(values)
    return float(size[:, _CARTS].max()), float(size[:, _TELESCOPES].max())
