"""Columns in other units: millimetres for metres, degrees for radians, with names that say so."""

import re
from collections.abc import Mapping

import numpy as np

from pipeline.export.csv import Column
from pipeline.export.formats import AngleUnit, LengthUnit

_LENGTHS = re.compile(r"_(m|mps|mps2)$")
_ANGLES = re.compile(r"_rad$")


def converted(columns: Mapping[str, Column], length: LengthUnit, angle: AngleUnit) -> dict[str, Column]:
    """Write columns in the units asked for: q1_m becomes q1_mm, qd1_mps becomes qd1_mmps, rx_rad becomes rx_deg."""
    found: dict[str, Column] = {}
    for name, values in columns.items():
        if length is LengthUnit.MM and _LENGTHS.search(name):
            found[_LENGTHS.sub(r"_m\1", name)] = values * 1_000.0
        elif angle is AngleUnit.DEG and _ANGLES.search(name):
            found[_ANGLES.sub("_deg", name)] = np.rad2deg(values)
        else:
            found[name] = values
    return found
