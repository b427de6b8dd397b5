"""The criteria that paths are compared by, a row each: unit, which value is better, and what counts as equal."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pipeline.compare.motion import MotionFigures, at_duration
from pipeline.limits import Measure, measures
from pipeline.refine.measure import PathFigures
from pipeline.retime import MotionQuality

Preference = Literal["lower", "higher", "neither"]


@dataclass(frozen=True)
class MeasuredPath:
    """A path in numbers; None for what is not known.

    Attributes
    ----------
    path : PathFigures
        Figures of the curve itself.
    motion : MotionFigures or None
        Figures of the curve in time.
    paced : MotionFigures or None
        Figures of the same motion, slowed down to the duration of the slowest one in the comparison.
    """

    path: PathFigures
    motion: MotionFigures | None = None
    paced: MotionFigures | None = None


def paced_alike(measured: Sequence[MeasuredPath]) -> list[MeasuredPath]:
    """Slow all motions down to the longest duration, so that their peaks show which curve is smoother."""
    durations = [one.motion.duration_s for one in measured if one.motion is not None]
    if len(durations) < len(measured):
        return list(measured)
    longest = max(durations)
    return [replace(one, paced=one.motion and at_duration(one.motion, longest)) for one in measured]


@dataclass(frozen=True)
class Criterion:
    """A criterion: name and unit, the better direction, the difference up to which values are equal, how it is read."""

    name: str
    unit: str
    prefers: Preference
    resolution: float
    read: Callable[[MeasuredPath], float | None]

    def value(self, measured: MeasuredPath) -> float | None:
        """Read the value; None where it is unknown or unbounded."""
        value = self.read(measured)
        return None if value is None or not np.isfinite(value) else float(value)


def _path(name: str, unit: str, prefers: Preference, resolution: float, attribute: str) -> Criterion:
    return Criterion(name, unit, prefers, resolution, lambda one: getattr(one.path, attribute))


def _measure(measure: Measure) -> Criterion:
    return Criterion(
        measure.name, measure.unit, measure.prefers, measure.resolution, lambda one: one.path.measures.get(measure.key)
    )


def _motion(name: str, unit: str, resolution: float, attribute: str, paced: bool = False) -> Criterion:
    def read(one: MeasuredPath) -> float | None:
        motion = one.paced if paced else one.motion
        return None if motion is None else getattr(motion, attribute)

    return Criterion(name, unit, "lower", resolution, read)


def _quality(name: str, resolution: float, read: Callable[[MotionQuality], float | None]) -> Criterion:
    def read_of_motion(one: MeasuredPath) -> float | None:
        quality = None if one.motion is None else one.motion.quality
        return None if quality is None else read(quality)

    return Criterion(name, "", "lower", resolution, read_of_motion)


# Differences below the resolution come from sampling and rounding, not from the paths. Peaks that reach a limit come
# within a per cent of it.
CRITERIA = (
    _path("kappa integral", "steps", "lower", 1e-6, "kappa_integral"),
    _path("largest kappa", "", "lower", 1e-6, "kappa_max"),
    _path("largest kappa at s", "", "neither", 1e-6, "kappa_max_s"),
    _path("length", "steps", "lower", 1e-6, "length"),
    _path("length in actuator space", "m", "lower", 1e-6, "actuator_length_m"),
    _path("length against straight line", "", "lower", 1e-6, "length_ratio"),
    *(_measure(measure) for measure in measures()),
    _path("closure residual", "m", "lower", 1e-9, "closure_residual_m"),
    Criterion("working-mode changes", "", "neither", 0.5, lambda one: one.path.mode_changes),
    _motion("duration", "s", 1e-6, "duration_s"),
    _quality("duration against least time", 1e-6, lambda quality: quality.time_ratio),
    _quality("sign changes of velocity", 0.5, lambda quality: sum(quality.velocity_sign_changes)),
    _quality("sign changes of acceleration", 0.5, lambda quality: sum(quality.acceleration_sign_changes)),
    _motion("peak cart acceleration", "m/s^2", 2e-2, "cart_acceleration_mps2"),
    _motion("peak telescope acceleration", "m/s^2", 5e-3, "telescope_acceleration_mps2"),
    _motion("peak cart jerk", "m/s^3", 0.4, "cart_jerk_mps3"),
    _motion("peak telescope jerk", "m/s^3", 0.1, "telescope_jerk_mps3"),
    _motion("equally long: cart acceleration", "m/s^2", 2e-2, "cart_acceleration_mps2", paced=True),
    _motion("equally long: telescope acceleration", "m/s^2", 5e-3, "telescope_acceleration_mps2", paced=True),
    _motion("equally long: cart jerk", "m/s^3", 0.4, "cart_jerk_mps3", paced=True),
    _motion("equally long: telescope jerk", "m/s^3", 0.1, "telescope_jerk_mps3", paced=True),
)
"""All criteria, in the order of the table."""
