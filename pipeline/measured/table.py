"""Measured motions as tables: columns of two reflectors, or of the pose as in `trajectory.csv`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.export.trajectory_columns import POSE
from pipeline.machine.pose import CONTROLLED

TIME = "t_s"
REFLECTORS = tuple(f"{axis}{number}_m" for number in (1, 2) for axis in "xyz")
"""Columns of the reflectors: x, y, z of the first, then of the second, in the frame of the machine."""
MEASURED_POSE = tuple(POSE[index] for index in CONTROLLED)
"""Columns of a measured pose, named as in `trajectory.csv`; other columns are ignored."""


@dataclass(frozen=True, eq=False)
class Measurement:
    """A measurement: either reflectors or poses over time.

    Attributes
    ----------
    t_s : (n,)
        Time since the start of the motion, increasing.
    reflectors_m : (n, 2, 3) or None
        Positions of both reflectors.
    controlled : (n, 5) or None
        x, y, z in metres, rx, rz in radians.
    """

    t_s: FloatArray
    reflectors_m: FloatArray | None
    controlled: FloatArray | None


def measurement_columns(t_s: FloatArray, reflectors_m: FloatArray) -> dict[str, FloatArray]:
    """Name the columns of a measurement: time (n,) and both reflectors (n, 2, 3)."""
    return {TIME: t_s, **dict(zip(REFLECTORS, reflectors_m.reshape(-1, 6).T, strict=True))}


def parse_measurement(columns: Mapping[str, npt.NDArray[Any]], duration_s: float) -> Measurement:
    """Read a measurement of a motion of `duration_s` from columns; reflectors take precedence over a pose.

    Raises
    ------
    UsageError
        When columns are missing or hold anything but finite numbers, or times do not increase within the motion.
    """
    names = next((names for names in (REFLECTORS, MEASURED_POSE) if set(names) <= set(columns)), None)
    if names is None or TIME not in columns:
        raise UsageError(
            f"the columns {', '.join(columns)} are not a measurement.\n  What to change: give {TIME} and either "
            f"{', '.join(REFLECTORS)} or {', '.join(MEASURED_POSE)}."
        )
    values = [_numbers(name, columns[name]) for name in (TIME, *names)]
    t_s, rest = values[0], np.column_stack(values[1:])
    _check_times(t_s, duration_s)
    if names is REFLECTORS:
        return Measurement(t_s, rest.reshape(-1, 2, 3), None)
    return Measurement(t_s, None, rest)


def _numbers(name: str, values: npt.NDArray[Any]) -> FloatArray:
    if values.dtype.kind not in "if" or not np.isfinite(values).all():
        raise UsageError(f"column {name} holds values that are not finite numbers")
    return values.astype(float)


def _check_times(t_s: FloatArray, duration_s: float) -> None:
    if len(t_s) == 0:
        raise UsageError("the measurement has no rows")
    if not (np.diff(t_s) > 0.0).all():
        raise UsageError(f"times in {TIME} must increase from row to row")
    # Times are written with a fixed number of decimals.
    if t_s[0] < -1e-9 or t_s[-1] > duration_s + 1e-9:
        raise UsageError(
            f"times from {t_s[0]:g} to {t_s[-1]:g} s are not within the motion, which lasts {duration_s:g} s.\n"
            f"  What to change: count {TIME} from the start of the motion, and remove rows before and after it; for a "
            "motion exported at another speed or period, give --speed or --period."
        )
