"""Files of static poses: encoders q1_m to q5_m and reflectors x1_m, y1_m, z1_m, ... in one row per pose."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.calibrate.data.poses import StaticPoses
from pipeline.errors import UsageError
from pipeline.export.trajectory_columns import POSE, POSITIONS
from pipeline.measured.reading import Account, read_table
from pipeline.measured.reading.decoding import read_bytes


def reflector_columns(number: int) -> tuple[str, ...]:
    """Name the columns of a reflector, counted from 1."""
    return tuple(f"{axis}{number}_m" for axis in "xyz")


class PosesFile(NamedTuple):
    """A file that was read: how, and the hash of its content."""

    account: Account
    sha256: str


def read_poses(files: Sequence[Path], reflector_count: int) -> tuple[StaticPoses, list[PosesFile]]:
    """Read static poses from files, as `read_table` reads tables; reflectors may have gaps where they were not seen.

    Raises
    ------
    UsageError
        When anything else is in a file, or it has columns of more reflectors; names file, line and column.
    OSError
        When a file cannot be read.
    """
    read = [_read(file, reflector_count) for file in files]
    ends = np.cumsum([len(poses) for poses, _ in read])

    def place(row: int) -> str:
        index = int(np.searchsorted(ends, row, side="right"))
        return read[index][1].account.place(row - (int(ends[index - 1]) if index else 0))

    q, seen = (np.concatenate([getattr(poses, name) for poses, _ in read]) for name in ("q_m", "seen_m"))
    return StaticPoses(q, seen, place), [one for _, one in read]


def read_places(file: Path) -> tuple[FloatArray, FloatArray]:
    """Read what encoders show (n, 5), and poses x_m ... rz_rad (n, 6), of a table of poses to measure.

    Raises
    ------
    UsageError
        When anything else is in the file; names file, line and column.
    OSError
        When it cannot be read.
    """
    columns = read_table(read_bytes(file), str(file), [(*POSITIONS, *POSE)]).columns
    q, pose = (np.column_stack([columns[name] for name in names]) for names in (POSITIONS, POSE))
    return q, pose


def _read(file: Path, count: int) -> tuple[StaticPoses, PosesFile]:
    data, numbers = read_bytes(file), range(1, count + 1)
    reflectors = tuple(name for number in numbers for name in reflector_columns(number))
    more = reflector_columns(count + 1)
    table = read_table(
        data, str(file), [(*POSITIONS, *reflectors, *more), (*POSITIONS, *reflectors)], reflectors + more
    )
    if more[0] in table.columns:
        raise UsageError(
            f"{file}: has columns of a reflector {count + 1}, but places of {count} are given.\n"
            f"  What to change: give --reflector-{count + 1} X Y Z, or remove the columns."
        )
    q, seen = (np.column_stack([table.columns[name] for name in names]) for names in (POSITIONS, reflectors))
    poses = StaticPoses(q, seen.reshape(len(q), count, 3), table.account.place)
    return poses, PosesFile(table.account, hashlib.sha256(data).hexdigest())
