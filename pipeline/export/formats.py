"""The formats and units that trajectories are exported in, by their names on the command line."""

from enum import StrEnum

MOST_DECIMALS = 17
"""Largest number of decimals: all digits that a number near one has."""


class Format(StrEnum):
    """Formats of trajectories, a row each: its name, and the functions of this package that write and read it.

    Functions are named by module, and imported when a format is used: a help text does not wait for NumPy.

    Attributes
    ----------
    writer : str
        Takes an `ExportRequest`, returns the text.
    reader : str
        Takes the text, returns a `Motion`.
    """

    writer: str
    reader: str

    def __new__(cls, name: str, writer: str, reader: str) -> "Format":
        """Make a row whose value is the name."""
        row = str.__new__(cls, name)
        row._value_ = name
        row.writer, row.reader = writer, reader
        return row

    CSV = "csv", "trajectory_csv.format_trajectory_csv", "trajectory_csv.read_trajectory_csv"
    ROS2 = "ros2", "ros2.format_yaml", "ros2.read_joint_trajectory"
    ROS2_JSON = "ros2-json", "ros2.format_json", "ros2.read_joint_trajectory"
    LINUXCNC = "linuxcnc", "linuxcnc.format_halstreamer", "linuxcnc.read_halstreamer"
    BECKHOFF = "beckhoff", "beckhoff.format_beckhoff", "beckhoff.read_beckhoff"
    MUJOCO = "mujoco", "mujoco.format_keyframes", "mujoco.read_keyframes"


class LengthUnit(StrEnum):
    """Unit of lengths in a CSV file."""

    M = "m"
    MM = "mm"


class AngleUnit(StrEnum):
    """Unit of angles in a CSV file."""

    RAD = "rad"
    DEG = "deg"


class Separator(StrEnum):
    """Separator of the values in a CSV file."""

    COMMA = "comma"
    SEMICOLON = "semicolon"
    TAB = "tab"

    @property
    def character(self) -> str:
        """The character itself."""
        return {Separator.COMMA: ",", Separator.SEMICOLON: ";", Separator.TAB: "\t"}[self]
