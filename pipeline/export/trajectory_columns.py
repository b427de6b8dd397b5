"""The columns of `trajectory.csv`, a row each in the order of the file: name, unit, meaning, and how it is read."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, NamedTuple

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import ACTUATORS

if TYPE_CHECKING:
    from pipeline.retime.result import TrajectorySamples


class TrajectoryColumn(NamedTuple):
    """A column of `trajectory.csv`; `read` takes its values (n,) from samples of a trajectory."""

    name: str
    unit: str
    meaning: str
    read: "Callable[[TrajectorySamples], FloatArray]"


_ACTUATOR_TEXTS = (
    "cart 1 along its rail",
    "cart 2 along its rail",
    "cart 3 along its rail",
    "length of telescope 2b",
    "length of telescope 3b",
)


def _per_actuator(
    prefix: str, suffix: str, unit: str, meaning: str, read: "Callable[[TrajectorySamples], FloatArray]"
) -> tuple[TrajectoryColumn, ...]:
    """Name a column per actuator, in their order, of values (n, 5)."""
    return tuple(
        TrajectoryColumn(f"{prefix}{k + 1}_{suffix}", unit, f"{meaning}, {actuator}: {text}", _at(k, read))
        for k, (actuator, text) in enumerate(zip(ACTUATORS, _ACTUATOR_TEXTS, strict=True))
    )


def _at(k: int, read: "Callable[[TrajectorySamples], FloatArray]") -> "Callable[[TrajectorySamples], FloatArray]":
    return lambda samples: read(samples)[:, k]


def _pose(k: int, name: str, meaning: str) -> TrajectoryColumn:
    return TrajectoryColumn(name, name.rsplit("_", 1)[1], meaning, lambda samples: samples.pose[:, k])


_POSITIONS = _per_actuator("q", "m", "m", "position", lambda samples: samples.q_m)
_VELOCITIES = _per_actuator("qd", "mps", "m/s", "velocity at that instant", lambda samples: samples.qd_mps)
_ACCELERATIONS = _per_actuator(
    "qdd",
    "mps2",
    "m/s^2",
    "acceleration from that instant on (where it jumps, the value after the jump)",
    lambda samples: samples.qdd_mps2,
)
_POSES = (
    _pose(0, "x_m", "TCP along the rails"),
    _pose(1, "y_m", "TCP along the depth of the frame"),
    _pose(2, "z_m", "TCP along its height"),
    _pose(3, "rx_rad", "platform turned about x, after y and z: R = Rx(rx) Rz(rz) Ry(ry)"),
    _pose(4, "ry_rad", "platform turned about y, first; follows from the other five"),
    _pose(5, "rz_rad", "platform turned about z, after y"),
)

TRAJECTORY_COLUMNS = (
    TrajectoryColumn("t_s", "s", "time since the start", lambda samples: samples.t_s),
    *_POSITIONS,
    *_VELOCITIES,
    *_ACCELERATIONS,
    *_POSES,
    TrajectoryColumn(
        "kappa",
        "1",
        "condition number of the statics matrix H, moments per machine.characteristic_length_m",
        lambda samples: samples.kappa,
    ),
)
"""All columns of `trajectory.csv`."""

POSITIONS, VELOCITIES, ACCELERATIONS = (
    tuple(column.name for column in group) for group in (_POSITIONS, _VELOCITIES, _ACCELERATIONS)
)
"""Names of the columns of the actuators, in the order of `ACTUATORS`."""
JERKS = tuple(f"qddd{k + 1}_mps3" for k in range(len(ACTUATORS)))
"""Names of the columns that exports have on request: jerk from that instant on."""
POSE = tuple(column.name for column in _POSES)
"""Names of the columns of the pose."""


def trajectory_columns(
    samples: "TrajectorySamples", columns: Iterable[TrajectoryColumn] = TRAJECTORY_COLUMNS
) -> dict[str, FloatArray]:
    """Read the columns of `trajectory.csv` from samples: values (n,) by name, in the order of the file."""
    return {column.name: column.read(samples) for column in columns}
