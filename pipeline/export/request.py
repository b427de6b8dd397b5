"""What every format is written from: samples of a trajectory, how precise they have to be, and options."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np
from typing_extensions import deprecated

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.export.formats import (
    MOST_DECIMALS,
    TOLERANCE_M,
    AngleUnit,
    DecimalMark,
    Format,
    LengthUnit,
    Separator,
    Times,
)
from pipeline.machine.actuator_space.controller_units import ControllerUnits
from pipeline.machine.geometry import Machine
from pipeline.retime.result import TrajectorySamples

if TYPE_CHECKING:
    from pipeline.certify.recheck.tube import ProvenTube

_ROUNDING_SHARE = 1e-4
"""Fraction of an acceleration limit that rounding may contribute when written positions are differenced twice."""
_OF_OPTIONS = {"lead_in_s": "--lead-in", "tolerance_m": "--tolerance"}


@dataclass(frozen=True)
class ExportOptions:
    """How a file is written; `Format.options` lists which of these a format takes.

    Attributes
    ----------
    separator, decimal : Separator, DecimalMark
        Of tables; commas cannot be both.
    decimals : int or None
        Of tables; None: as many as the period needs.
    columns : tuple of str or None
        Columns by their names in SI units; None: those of `trajectory.csv`.
    length, angle : LengthUnit, AngleUnit
        Units.
    names : tuple of str or None
        Other names for the columns, in their order.
    times : Times
        Since the start, or since the row before.
    lead_in_s : float
        Time that a controller has to reach the first point.
    tolerance_m : float
        How far positions may be off where points are left out.
    """

    separator: Separator = Separator.COMMA
    decimals: int | None = None
    columns: tuple[str, ...] | None = None
    length: LengthUnit = LengthUnit.M
    angle: AngleUnit = AngleUnit.RAD
    decimal: DecimalMark = DecimalMark.POINT
    names: tuple[str, ...] | None = None
    times: Times = Times.ABSOLUTE
    lead_in_s: float = 0.0
    tolerance_m: float = TOLERANCE_M

    def require_for(self, kind: Format) -> None:
        """Refuse options that the format does not take, and values that exclude each other.

        Raises
        ------
        UsageError
            Names the option and the formats that take it.
        """
        for field in fields(self):
            if getattr(self, field.name) != field.default and field.name not in kind.options:
                option = _OF_OPTIONS.get(field.name, f"--{field.name}")
                takers = ", ".join(one for one in Format if field.name in one.options)
                raise UsageError(f"{option} goes with --format {takers} only, not with {kind}")
        if self.decimal is DecimalMark.COMMA and self.separator is Separator.COMMA:
            raise UsageError(
                "--decimal comma: commas cannot separate values, too.\n"
                "  What to change: --separator semicolon, as in German locales, or --separator tab."
            )
        if not 0.0 <= self.lead_in_s <= 3_600.0:
            raise UsageError(f"--lead-in is {self.lead_in_s:g}; allowed are 0 to 3600 seconds")
        if not 0.0 <= self.tolerance_m < math.inf:
            raise UsageError(f"--tolerance is {self.tolerance_m:g}; allowed are metres from 0")


@deprecated("CsvOptions is now called ExportOptions")
class CsvOptions(ExportOptions):
    """The options while only CSV had any, by their name of then."""


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
    options : ExportOptions
        Options of the format.
    machine : Machine or None
        The machine, for formats that describe it or its passive joints.
    jerk_mps3 : (n, 5) or None
        Jerk from each instant on; None where accelerations jump.
    tube : ProvenTube or None
        How far actuators may be off the path, for formats with trip limits; None if that is not proven.
    deviation_m : (5,) or None
        How far what is driven between the rows is off the motion; None where controllers drive the rows alone.
    units : ControllerUnits or None
        What the controller's positions are; None: those of the geometry, in which all that is here is given.
    """

    samples: TrajectorySamples
    acceleration_mps2: FloatArray
    joint_names: Sequence[str]
    options: ExportOptions = ExportOptions()  # frozen
    machine: Machine | None = None
    jerk_mps3: FloatArray | None = None
    tube: "ProvenTube | None" = None
    deviation_m: FloatArray | None = None
    units: ControllerUnits | None = None

    def for_controller(self) -> "ExportRequest":
        """Give the same request with the motion in the units of the controller."""
        if self.units is None:
            return self
        units, tube = self.units, self.tube
        return replace(
            self,
            samples=self.samples.for_controller(units),
            jerk_mps3=None if self.jerk_mps3 is None else units.rates_to_controller(self.jerk_mps3),
            tube=None if tube is None else replace(tube, errors_m=units.rates_to_controller(tube.errors_m)),
            deviation_m=None if self.deviation_m is None else units.rates_to_controller(self.deviation_m),
            units=None,
        )

    def needed_decimals(self, unit_m: float = 1.0) -> int:
        """Count the decimals needed for positions in a unit of length, 0.001 for millimetres."""
        return needed_decimals(self.samples.period_s, self.acceleration_mps2, unit_m)


def require_machine(request: ExportRequest) -> Machine:
    """Return the machine of a request.

    Raises
    ------
    UsageError
        When the request has none.
    """
    if request.machine is None:
        raise UsageError("this format describes the machine: give ExportRequest its `machine`")
    return request.machine


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
