"""Poses to drive to, from a table such as `calibrate --next-output` writes."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.atlas.stations import Station
from pipeline.config import Config, PoseConfig
from pipeline.export.trajectory_columns import POSE, POSITIONS
from pipeline.machine.actuator_space.controller_units import controller_units
from pipeline.machine.geometry import build_machine
from pipeline.machine.working_modes import mode_names, reach_along_rails
from pipeline.measured.reading import read_table
from pipeline.measured.reading.decoding import read_bytes

_REFLECTORS = tuple(tuple(f"{axis}{number}_m" for axis in "xyz") for number in (1, 2, 3))
_MICRODEGREES = 6
_NANOMETRES = 9


@dataclass(frozen=True)
class StopTable:
    """Poses to drive to.

    Attributes
    ----------
    stations : tuple of Station
        A pose per row, in its working mode, named by the number of the row.
    blanks : tuple of str
        Columns of reflectors, to be filled in where the machine stands.
    """

    stations: tuple[Station, ...]
    blanks: tuple[str, ...]


def read_stops(file: Path, config: Config) -> StopTable:
    """Read poses x_m ... rz_rad, with actuators q1_m ... q5_m, of which carts tell the working modes.

    Raises
    ------
    UsageError
        When anything else is in the file; names file, line and column.
    OSError
        When it cannot be read.
    """
    blanks = [tuple(name for group in _REFLECTORS[:count] for name in group) for count in (3, 2, 1, 0)]
    choices = [(*POSITIONS, *names, *POSE) for names in blanks]
    table = read_table(read_bytes(file), str(file), choices, blanks[0])
    machine = build_machine(config.machine)
    pose = np.column_stack([table.columns[name] for name in POSE])
    shown = np.column_stack([table.columns[name] for name in POSITIONS])
    carts = controller_units(config.machine).to_geometry(shown)[:, :3]
    modes = mode_names(np.where(reach_along_rails(machine, pose, carts) < 0.0, -1.0, 1.0))
    width = len(str(len(pose)))
    stations = tuple(
        Station(f"pose-{k + 1:0{width}}", _pose_config(place, mode), table.account.place(k))
        for k, (place, mode) in enumerate(zip(pose, modes, strict=True))
    )
    return StopTable(stations, tuple(name for name in blanks[0] if name in table.columns))


def _pose_config(pose: FloatArray, mode: str) -> PoseConfig:
    x, y, z = np.round(pose[:3], _NANOMETRES).tolist()
    rx, rz = np.round(np.rad2deg(pose[[3, 5]]), _MICRODEGREES).tolist()
    return PoseConfig(x_m=x, y_m=y, z_m=z, rx_deg=rx, rz_deg=rz, mode=mode)
