"""Measured motions as tables: columns of two reflectors, or of the pose as in `trajectory.csv`."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.export.trajectory_columns import POSE
from pipeline.machine.pose import CONTROLLED
from pipeline.measured.reading import Account, match_columns, read_table
from pipeline.measured.reading.decoding import read_bytes

TIME = "t_s"
REFLECTORS = tuple(f"{axis}{number}_m" for number in (1, 2) for axis in "xyz")
"""Columns of the reflectors: x, y, z of the first, then of the second, in the frame of the machine."""
MEASURED_POSE = tuple(POSE[index] for index in CONTROLLED)
"""Columns of a measured pose, named as in `trajectory.csv`; other columns are ignored."""
_CHOICES = ((TIME, *REFLECTORS), (TIME, *MEASURED_POSE))
_ROUNDING_S = 1e-9
"""Times are written with a fixed number of decimals."""
_FINER_CLOCKS = {"milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}
_MOST_LATE = 20.0
"""Largest time, in durations, that is too late rather than in another unit."""


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
    account : Account or None
        How the file was read, and what of it was skipped; None where there was no file.
    """

    t_s: FloatArray
    reflectors_m: FloatArray | None
    controlled: FloatArray | None
    account: Account | None = None

    def place(self, row: int) -> str:
        """Say where a row is: its line in the file, or its index."""
        return f"index {row}" if self.account is None else self.account.place(row)


def measurement_columns(t_s: FloatArray, reflectors_m: FloatArray) -> dict[str, FloatArray]:
    """Name the columns of a measurement: time (n,) and both reflectors (n, 2, 3)."""
    return {TIME: t_s, **dict(zip(REFLECTORS, reflectors_m.reshape(-1, 6).T, strict=True))}


def read_measurement(file: Path | str, duration_s: float) -> Measurement:
    """Read a measurement of a motion of `duration_s` from a file; reflectors take precedence over a pose.

    The file is a table as trackers and spreadsheets write it: `reading.read_table` says what is read and skipped; the
    result's `account` says what was.

    Raises
    ------
    UsageError
        When anything else is in the file, or times do not increase within the motion; names file, line and column.
    OSError
        When the file cannot be read.
    """
    _require_duration(duration_s)
    table = read_table(read_bytes(Path(file)), str(file), _CHOICES)
    return _measurement(table.columns, duration_s, table.account)


def parse_measurement(columns: Mapping[str, npt.ArrayLike], duration_s: float) -> Measurement:
    """Take a measurement of a motion of `duration_s` from columns (n,); reflectors take precedence over a pose.

    Columns are found by name, as in files; rows with gaps have to be left out.

    Raises
    ------
    UsageError
        When columns are missing, differ in length or hold anything but finite numbers, or times do not increase within
        the motion; names column and index.
    """
    _require_duration(duration_s)
    try:
        names = match_columns([str(name) for name in columns], _CHOICES)
    except ValueError as error:
        raise UsageError(
            f"the columns {', '.join(map(str, columns))} are not a measurement.\n  {error}\n"
            f"  What to change: give {TIME} and either {', '.join(REFLECTORS)} or {', '.join(MEASURED_POSE)}."
        ) from None
    values = {name: _numbers(name, np.asarray(columns[given])) for name, given in names.items()}
    if len({len(column) for column in values.values()}) > 1:
        lengths = ", ".join(f"{name} {len(column)}" for name, column in values.items())
        raise UsageError(f"columns of a measurement must have the same number of rows: {lengths}")
    return _measurement(values, duration_s, None)


def _measurement(columns: Mapping[str, FloatArray], duration_s: float, account: Account | None) -> Measurement:
    t_s = columns[TIME]
    rest = np.column_stack([values for name, values in columns.items() if name != TIME])
    reflectors = REFLECTORS[0] in columns
    measurement = Measurement(
        t_s, rest.reshape(-1, 2, 3) if reflectors else None, None if reflectors else rest, account
    )
    _check_order(measurement)
    _check_range(measurement, duration_s)
    return measurement


def _require_duration(duration_s: float) -> None:
    if not (isfinite(duration_s) and duration_s >= 0.0):
        raise UsageError(f"the duration of a motion must be a finite number of seconds, not {duration_s}")


def _numbers(name: str, values: npt.NDArray[Any]) -> FloatArray:
    if values.ndim != 1:
        raise UsageError(f"column {name} must be one-dimensional, not of shape {values.shape}")
    if values.dtype.kind not in "iuf":
        raise UsageError(f"column {name} holds values that are not finite numbers: they are of type {values.dtype}")
    if not (finite := np.isfinite(values)).all():
        at = int(np.argmin(finite))
        raise UsageError(
            f"column {name} holds values that are not finite numbers: {values[at]} at index {at}, and "
            f"{np.count_nonzero(~finite) - 1:,} more.\n  What to change: leave out rows with gaps."
        )
    return values.astype(float)


def _check_order(measurement: Measurement) -> None:
    t_s = measurement.t_s
    if len(t_s) == 0:
        raise UsageError("the measurement has no rows")
    later = np.diff(t_s) > 0.0
    if later.all():
        return
    row = int(np.argmin(later)) + 1
    repeated = t_s[row] == t_s[row - 1]
    advice = (
        f"write {TIME} with more decimals, or leave repeated rows out."
        if (np.diff(t_s) >= 0.0).all()
        else "sort the rows; if the motion was measured twice, give each in a file of its own."
    )
    raise UsageError(
        f"{measurement.place(row)}: times in {TIME} must increase from row to row, but {t_s[row]:.9g} "
        f"{'is there twice' if repeated else f'follows {t_s[row - 1]:.9g}'} "
        f"(so {np.count_nonzero(~later):,} times).\n  What to change: {advice}"
    )


def _check_range(measurement: Measurement, duration_s: float) -> None:
    t_s = measurement.t_s
    outside = (t_s < -_ROUNDING_S) | (t_s > duration_s + _ROUNDING_S)
    if not outside.any():
        return
    row = int(np.argmax(outside))
    said = (
        f"{measurement.place(row)}: times from {t_s[0]:g} to {t_s[-1]:g} s are not within the motion, which lasts "
        f"{duration_s:g} s ({np.count_nonzero(outside):,} rows outside)."
    )
    for name, factor in _FINER_CLOCKS.items():
        if t_s[0] >= -_ROUNDING_S and _MOST_LATE * duration_s < t_s[-1] <= factor * (duration_s + _ROUNDING_S):
            raise UsageError(f"{said}\n  They look like {name}.\n  What to change: divide {TIME} by {factor:.0f}.")
    raise UsageError(
        f"{said}\n  What to change: count {TIME} from the start of the motion, and remove rows before and after it; "
        "for a motion exported at another speed or period or as the way back, give --speed or --period or --back."
    )
