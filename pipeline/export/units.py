"""Columns in other units: millimetres instead of metres, degrees instead of radians, with names to match."""

import re
from collections.abc import Mapping

import numpy as np

from pipeline.export.csv import Column
from pipeline.export.formats import AngleUnit, LengthUnit

_LENGTHS = re.compile(r"_(m|mps|mps2|mps3)$")
_ANGLES = re.compile(r"_rad$")


def converted(columns: Mapping[str, Column], length: LengthUnit, angle: AngleUnit) -> dict[str, Column]:
    """Convert columns to the units asked for: q1_m becomes q1_mm, qd1_mps becomes qd1_mmps, rx_rad becomes rx_deg."""
    result: dict[str, Column] = {}
    for name, values in columns.items():
        if length is LengthUnit.MM and _LENGTHS.search(name):
            result[_LENGTHS.sub(r"_m\1", name)] = values * 1_000.0
        elif angle is AngleUnit.DEG and _ANGLES.search(name):
            result[_ANGLES.sub("_deg", name)] = np.rad2deg(values)
        else:
            result[name] = values
    return result
