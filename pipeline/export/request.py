"""What every format is written from: samples of a trajectory, how precise they have to be, and options."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.export.formats import MOST_DECIMALS, AngleUnit, LengthUnit, Separator
from pipeline.retime.result import TrajectorySamples

_ROUNDING_SHARE = 1e-4
"""Fraction of an acceleration limit that rounding may contribute when written positions are differenced twice."""


@dataclass(frozen=True)
class CsvOptions:
    """How a CSV file is written: columns by their names in SI units (None: all), and decimals (None: as needed)."""

    separator: Separator = Separator.COMMA
    decimals: int | None = None
    columns: tuple[str, ...] | None = None
    length: LengthUnit = LengthUnit.M
    angle: AngleUnit = AngleUnit.RAD


@dataclass(frozen=True, eq=False)
class ExportRequest:
    """A trajectory to be written.

    Attributes
    ----------
    samples : TrajectorySamples
        Its rows.
    acceleration_mps2 : (5,)
        Acceleration limits, which decide how many decimals are needed.
    joint_names : sequence of str
        Names of the five actuators, for formats that have them.
    options : CsvOptions
        Options of the CSV format.
    """

    samples: TrajectorySamples
    acceleration_mps2: FloatArray
    joint_names: Sequence[str]
    options: CsvOptions = CsvOptions()  # frozen

    def needed_decimals(self, unit_m: float = 1.0) -> int:
        """Count the decimals needed for positions in a unit of length, 0.001 for millimetres."""
        return needed_decimals(self.samples.period_s, self.acceleration_mps2, unit_m)


def needed_decimals(period_s: float, acceleration_mps2: FloatArray, unit_m: float = 1.0) -> int:
    """Count the decimals with which positions differenced twice give accelerations to 0.01 % of the smallest limit.

    Rounding by half of the last decimal contributes up to 4 (10^-d / 2) / period^2. There are never more decimals than
    a number has digits.

    Parameters
    ----------
    unit_m : float
        Unit of length in which positions are written: 0.001 for millimetres.
    """
    allowed = _ROUNDING_SHARE * float(np.min(acceleration_mps2)) / unit_m
    return min(MOST_DECIMALS, max(0, math.ceil(-math.log10(allowed * period_s**2 / 2.0) - 1e-9)))
