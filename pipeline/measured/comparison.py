"""A measured motion against the commanded one: errors and error bars, over time and summed up in rows."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeline.arguments import require_array
from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.machine.pose import CONTROLLED
from pipeline.measured.estimate import estimate_poses
from pipeline.measured.plausibility import require_direction, require_units
from pipeline.measured.reading import Account
from pipeline.measured.reflectors import Reflectors, reflector_positions
from pipeline.measured.rows import RowError
from pipeline.measured.table import MEASURED_POSE, REFLECTORS, Measurement


class Coordinate(NamedTuple):
    """A controlled coordinate: its name, the unit in which errors are shown, and the factor from SI units to it."""

    name: str
    unit: str
    scale: float


_DEG = 180.0 / np.pi
COORDINATES = (
    Coordinate("x", "mm", 1e3),
    Coordinate("y", "mm", 1e3),
    Coordinate("z", "mm", 1e3),
    Coordinate("rx", "deg", _DEG),
    Coordinate("rz", "deg", _DEG),
)
"""The controlled coordinates, in the order of a controlled pose."""
TABLE_HEADER = ("quantity", "unit", "mean error", "rms error", "largest error", "at s", "error bar", "rms / bar")
"""Headings of `table_cells`."""


@dataclass(frozen=True, eq=False)
class MeasurementComparison:
    """Controlled poses over time, x, y, z in metres, rx, rz in radians.

    Attributes
    ----------
    t_s : (n,)
        Time since the start of the motion.
    commanded, measured : (n, 5)
        What was commanded, and what was measured.
    std : (n, 5) or None
        Standard deviations of the measurement, due to noise; None where they are not known.
    account : Account or None
        How the file of the measurement was read, and what was skipped.
    """

    t_s: FloatArray
    commanded: FloatArray
    measured: FloatArray
    std: FloatArray | None
    account: Account | None = None

    @property
    def error(self) -> FloatArray:
        """The errors, measured - commanded. Shape (n, 5)."""
        return self.measured - self.commanded


@dataclass(frozen=True)
class ErrorRow:
    """The error of one coordinate over the motion, in metres or radians.

    Attributes
    ----------
    quantity : str
        x, y, z, rx or rz.
    mean, rms, largest : float
        Mean, root of the mean square, and the error of largest magnitude.
    largest_at_s : float
        The time of the largest error.
    error_bar : float or None
        Root of the mean variance of the measurement, due to noise.
    standardised_rms : float or None
        Root of the mean square of error / standard deviation: about 1 if there is only noise.
    """

    quantity: str
    mean: float
    rms: float
    largest: float
    largest_at_s: float
    error_bar: float | None
    standardised_rms: float | None


def compare_measurement(
    measurement: Measurement, commanded: FloatArray, reflectors: Reflectors
) -> MeasurementComparison:
    """Compare a measurement (n rows) with the poses (n, 6) commanded at its times.

    Raises
    ------
    UsageError
        When there is another number of poses, values are not finite, look like millimetres or degrees, or run the other
        way, or when the reflectors do not determine the pose.
    """
    if len(measurement.t_s) == 0:
        raise UsageError("the measurement has no rows")
    commanded = require_array("commanded poses", commanded, (len(measurement.t_s), 6))
    try:
        controlled, std = _controlled(measurement, commanded, reflectors)
    except RowError as error:
        raise UsageError(f"{measurement.place(error.row)}: {error.message}") from None
    return MeasurementComparison(measurement.t_s, commanded[:, CONTROLLED], controlled, std, measurement.account)


def _controlled(
    measurement: Measurement, commanded: FloatArray, reflectors: Reflectors
) -> tuple[FloatArray, FloatArray | None]:
    """Give measured controlled poses (n, 5), and their standard deviations if they are known."""
    count = len(commanded)
    if measurement.reflectors_m is not None:
        seen = require_array("measured reflectors", measurement.reflectors_m, (count, 2, 3))
        expected = reflector_positions(reflectors.points_m, commanded).reshape(-1, 6)
        require_units(REFLECTORS, seen.reshape(-1, 6), expected)
        require_direction(seen.reshape(-1, 6), expected)
        estimate = estimate_poses(reflectors, seen, commanded)
        return estimate.controlled, estimate.std if reflectors.noise_m > 0.0 else None
    if measurement.controlled is None:
        raise UsageError("a measurement needs positions of reflectors or poses")
    measured = require_array("measured poses", measurement.controlled, (count, 5))
    expected = commanded[:, CONTROLLED]
    require_units(MEASURED_POSE, measured, expected)
    require_direction(measured[:, :3], expected[:, :3])
    return measured, None


def error_rows(comparison: MeasurementComparison) -> list[ErrorRow]:
    """Sum up the errors, a row per coordinate."""
    return [_row(comparison, index) for index in range(len(COORDINATES))]


def _row(comparison: MeasurementComparison, index: int) -> ErrorRow:
    error = comparison.error[:, index]
    worst = int(np.argmax(np.abs(error)))
    std = None if comparison.std is None else comparison.std[:, index]
    return ErrorRow(
        quantity=COORDINATES[index].name,
        mean=float(error.mean()),
        rms=_rms(error),
        largest=float(error[worst]),
        largest_at_s=float(comparison.t_s[worst]),
        error_bar=None if std is None else _rms(std),
        standardised_rms=None if std is None else _rms(error / std),
    )


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def table_cells(rows: list[ErrorRow]) -> list[tuple[str, ...]]:
    """Format rows as text under `TABLE_HEADER`, in millimetres and degrees; unknown values are a dash."""
    return [_cells(row, shown.unit, shown.scale) for row, shown in zip(rows, COORDINATES, strict=True)]


def _cells(row: ErrorRow, unit: str, scale: float) -> tuple[str, ...]:
    return (
        row.quantity,
        unit,
        f"{scale * row.mean:+.4f}",
        f"{scale * row.rms:.4f}",
        f"{scale * row.largest:+.4f}",
        f"{row.largest_at_s:.3f}",
        "-" if row.error_bar is None else f"{scale * row.error_bar:.4f}",
        "-" if row.standardised_rms is None else f"{row.standardised_rms:.2f}",
    )
