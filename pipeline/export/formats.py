"""The formats and units trajectories can be exported in, by the names they have on the command line."""

from enum import StrEnum

MOST_DECIMALS = 17
"""Decimals at most: all digits that a number near one has."""


class Format(StrEnum):
    """What trajectories can be exported as."""

    CSV = "csv"
    ROS2 = "ros2"
    ROS2_JSON = "ros2-json"
    LINUXCNC = "linuxcnc"
    BECKHOFF = "beckhoff"
    MUJOCO = "mujoco"


class LengthUnit(StrEnum):
    """Unit of lengths in a CSV file."""

    M = "m"
    MM = "mm"


class AngleUnit(StrEnum):
    """Unit of angles in a CSV file."""

    RAD = "rad"
    DEG = "deg"


class Separator(StrEnum):
    """What stands between the values of a CSV file."""

    COMMA = "comma"
    SEMICOLON = "semicolon"
    TAB = "tab"

    @property
    def character(self) -> str:
        """The character itself."""
        return {Separator.COMMA: ",", Separator.SEMICOLON: ";", Separator.TAB: "\t"}[self]
