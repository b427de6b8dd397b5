"""The columns of `trajectory.csv`: names, units and meaning, in the order of the file."""

from typing import NamedTuple

from pipeline.machine.geometry import ACTUATORS


class ColumnGroup(NamedTuple):
    """Columns of one kind, one per actuator."""

    names: tuple[str, ...]
    unit: str
    meaning: str


class ColumnMeaning(NamedTuple):
    """What a column holds."""

    name: str
    unit: str
    meaning: str


_NUMBERS = range(1, len(ACTUATORS) + 1)
_ACTUATOR_TEXTS = (
    "cart 1 along X",
    "cart 2 along X",
    "cart 3 along X",
    "length of telescope 2b",
    "length of telescope 3b",
)

PER_ACTUATOR = (
    ColumnGroup(tuple(f"q{k}_m" for k in _NUMBERS), "m", "position"),
    ColumnGroup(tuple(f"qd{k}_mps" for k in _NUMBERS), "m/s", "velocity at that instant"),
    ColumnGroup(
        tuple(f"qdd{k}_mps2" for k in _NUMBERS),
        "m/s^2",
        "acceleration from that instant on (where it jumps, the value after the jump)",
    ),
)
"""Columns of the actuators, in the order of `ACTUATORS`."""

POSE = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")
"""Columns of the pose."""

_POSE_TEXTS = (
    "TCP along the rails",
    "TCP along the depth of the frame",
    "TCP along its height",
    "platform turned about x, after y and z: R = Rx(rx) Rz(rz) Ry(ry)",
    "platform turned about y, first; follows from the other five",
    "platform turned about z, after y",
)


def trajectory_meanings() -> tuple[ColumnMeaning, ...]:
    """Every column of `trajectory.csv` with its unit and meaning."""
    actuators = [
        ColumnMeaning(name, unit, f"{meaning}, {actuator}: {text}")
        for names, unit, meaning in PER_ACTUATOR
        for name, actuator, text in zip(names, ACTUATORS, _ACTUATOR_TEXTS, strict=True)
    ]
    pose = [ColumnMeaning(name, name.rsplit("_", 1)[1], text) for name, text in zip(POSE, _POSE_TEXTS, strict=True)]
    return (
        ColumnMeaning("t_s", "s", "time since the start"),
        *actuators,
        *pose,
        ColumnMeaning("kappa", "1", "condition number of the statics matrix H, its moments in metres"),
    )
