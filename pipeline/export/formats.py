"""The formats and units that trajectories are exported in, by their names on the command line."""

from collections.abc import Mapping
from enum import StrEnum

MOST_DECIMALS = 17
"""Largest number of decimals: all digits that a number near one has."""
TOLERANCE_M = 1e-6
"""How far positions may be off where points are left out, by default."""
TRIP_YAML, TRIP_INI = ".controller.yaml", ".ini"
TRIP_LIMITS = frozenset({TRIP_YAML, TRIP_INI})
"""Endings of the files with trip limits."""
_NONE: frozenset[str] = frozenset()
_TABLE = frozenset({"separator", "decimal", "names"})


class Format(StrEnum):
    """Formats of trajectories, a row each: its name, and the functions of this package that write and read it.

    Functions are named by module, and imported when a format is used: a help text does not wait for NumPy.

    Attributes
    ----------
    writer : str
        Takes an `ExportRequest`, returns the content: text, or bytes.
    reader : str
        Takes the content, returns a `Motion`; empty for a format that holds no motion.
    options : frozenset of str
        The fields of `ExportOptions` that the format takes.
    beside : mapping of str to str
        Files that belong beside it: their suffix, and the function that writes them like `writer`, or returns None
        if there is nothing to write.
    """

    writer: str
    reader: str
    options: frozenset[str]
    beside: Mapping[str, str]

    def __new__(
        cls,
        name: str,
        writer: str,
        reader: str,
        options: frozenset[str] = _NONE,
        beside: Mapping[str, str] | None = None,
    ) -> "Format":
        """Make a row whose value is the name."""
        row = str.__new__(cls, name)
        row._value_ = name
        row.writer, row.reader, row.options, row.beside = writer, reader, options, beside or {}
        return row

    @property
    def shows_the_machine(self) -> bool:
        """Whether it describes the machine, or moves such a description: written from the geometry as it is."""
        return self in (Format.MCAP, Format.MJCF, Format.URDF)

    @property
    def read_by(self) -> tuple[str, ...]:
        """The interpolations by which its rows are read: by what they hold, and by what is known of their readers."""
        return {
            Format.PVT: ("cubic",),
            Format.ROS2: ("quintic",),
            Format.ROS2_JSON: ("quintic",),
            Format.MCAP: ("quintic",),
            Format.LINUXCNC: ("linear",),
        }.get(self, ("linear", "cubic", "quintic"))

    CSV = (
        "csv",
        "trajectory_csv.format_trajectory_csv",
        "trajectory_csv.read_trajectory_csv",
        _TABLE | {"decimals", "columns", "length", "angle"},
    )
    PVT = "pvt", "controllers.pvt.format_pvt", "controllers.pvt.read_pvt", _TABLE | {"length", "times"}
    CAM = "cam", "controllers.cam.format_cam", "controllers.cam.read_cam", frozenset({"length", "tolerance_m"})
    ROS2 = (
        "ros2",
        "controllers.ros2.format_yaml",
        "controllers.ros2.read_joint_trajectory",
        frozenset({"lead_in_s"}),
        {TRIP_YAML: "controllers.trip_limits.format_ros2_constraints"},
    )
    ROS2_JSON = (
        "ros2-json",
        "controllers.ros2.format_json",
        "controllers.ros2.read_joint_trajectory",
        frozenset({"lead_in_s"}),
        {TRIP_YAML: "controllers.trip_limits.format_ros2_constraints"},
    )
    MCAP = "mcap", "controllers.mcap.format_mcap", "controllers.mcap.read_mcap", frozenset({"lead_in_s"})
    LINUXCNC = (
        "linuxcnc",
        "controllers.linuxcnc.format_halstreamer",
        "controllers.linuxcnc.read_halstreamer",
        frozenset({"length"}),
        {".hal": "controllers.linuxcnc.format_hal", TRIP_INI: "controllers.trip_limits.format_linuxcnc_ini"},
    )
    BECKHOFF = "beckhoff", "controllers.beckhoff.format_beckhoff", "controllers.beckhoff.read_beckhoff"
    MJCF = "mjcf", "models.mjcf.format_mjcf", "models.mjcf.read_mjcf"
    URDF = (
        "urdf",
        "models.urdf.format_urdf",
        "",
        _NONE,
        {".yaml": "models.urdf.format_loops"},
    )


class LengthUnit(StrEnum):
    """Unit of lengths in a file."""

    M = "m"
    MM = "mm"

    @property
    def metres(self) -> float:
        """The unit in metres."""
        return 0.001 if self is LengthUnit.MM else 1.0


class AngleUnit(StrEnum):
    """Unit of angles in a file."""

    RAD = "rad"
    DEG = "deg"


class Separator(StrEnum):
    """Separator of the values in a table."""

    COMMA = "comma"
    SEMICOLON = "semicolon"
    TAB = "tab"

    @property
    def character(self) -> str:
        """The character itself."""
        return {Separator.COMMA: ",", Separator.SEMICOLON: ";", Separator.TAB: "\t"}[self]


class DecimalMark(StrEnum):
    """What separates the decimals of a number in a table."""

    POINT = "point"
    COMMA = "comma"


class Times(StrEnum):
    """Times in a table of positions and velocities: since the start, or since the row before."""

    ABSOLUTE = "absolute"
    RELATIVE = "relative"
