"""A trajectory's samples in any of the formats, by its name."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.export.beckhoff import format_beckhoff
from pipeline.export.csv import DECIMALS, format_csv, trajectory_columns
from pipeline.export.formats import AngleUnit, Format, LengthUnit, Separator
from pipeline.export.linuxcnc import format_halstreamer
from pipeline.export.motion import motion_of, needed_decimals
from pipeline.export.mujoco import format_keyframes
from pipeline.export.ros2 import format_json, format_yaml
from pipeline.export.units import converted
from pipeline.retime.result import TrajectorySamples

_MILLIMETRE = 0.001


@dataclass(frozen=True)
class CsvOptions:
    """How a CSV file is written: columns by their names in SI units (None: all), and decimals (None: as needed)."""

    separator: Separator = Separator.COMMA
    decimals: int | None = None
    columns: tuple[str, ...] | None = None
    length: LengthUnit = LengthUnit.M
    angle: AngleUnit = AngleUnit.RAD


def format_samples(
    kind: Format,
    samples: TrajectorySamples,
    acceleration_mps2: FloatArray,
    joint_names: Sequence[str],
    options: CsvOptions | None = None,
) -> str:
    """Write samples in a format; numbers have the decimals that the period and the limits (5,) ask for, or all digits.

    Raises
    ------
    UsageError
        When the options ask for no columns, or for some that do not exist, for fewer decimals than the period needs, or
        for CSV's options in another format.
    """
    options = options or CsvOptions()
    if kind is Format.CSV:
        return _csv(samples, acceleration_mps2, options)
    if options != CsvOptions():
        raise UsageError("--separator, --decimals, --columns, --length and --angle go with --format csv alone")
    motion, period = motion_of(samples), samples.period_s
    decimals = max(DECIMALS, needed_decimals(period, acceleration_mps2))
    decimals_mm = max(DECIMALS - 3, needed_decimals(period, acceleration_mps2, _MILLIMETRE))
    writers: dict[Format, Callable[[], str]] = {
        Format.ROS2: lambda: format_yaml(motion, joint_names),
        Format.ROS2_JSON: lambda: format_json(motion, joint_names),
        Format.LINUXCNC: lambda: format_halstreamer(motion, decimals),
        Format.BECKHOFF: lambda: format_beckhoff(motion, joint_names, decimals_mm),
        Format.MUJOCO: lambda: format_keyframes(motion),
    }
    return writers[kind]()


def _csv(samples: TrajectorySamples, acceleration_mps2: FloatArray, options: CsvOptions) -> str:
    columns = trajectory_columns(samples)
    wanted = tuple(columns) if options.columns is None else options.columns
    if not wanted:
        raise UsageError(f"--columns names no column; there are {', '.join(columns)}")
    unknown = [name for name in wanted if name not in columns]
    if unknown:
        raise UsageError(f"there is no column {', '.join(unknown)}; there are {', '.join(columns)}")
    if len(set(wanted)) < len(wanted):
        raise UsageError(f"--columns names a column twice: {', '.join(wanted)}")
    unit = _MILLIMETRE if options.length is LengthUnit.MM else 1.0
    needed = needed_decimals(samples.period_s, np.asarray(acceleration_mps2), unit)
    if options.decimals is not None and options.decimals < needed:
        raise UsageError(
            f"{options.decimals} decimals are too few: with a period of {samples.period_s:g} s, rounding would show in "
            f"the accelerations a controller computes from positions.\n  What to change: at least {needed} decimals."
        )
    decimals = max(DECIMALS, needed) if options.decimals is None else options.decimals
    chosen = {name: columns[name] for name in wanted}
    return format_csv(converted(chosen, options.length, options.angle), decimals, options.separator.character)
