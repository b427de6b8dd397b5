"""Files of poses: encoders q1_m to q5_m, or times t_s of a motion, and reflectors x1_m, y1_m, z1_m, ... in each row."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.calibrate.data.motions import DrivenMotion
from pipeline.calibrate.data.poses import StaticPoses, Timing
from pipeline.errors import UsageError
from pipeline.export.trajectory_columns import POSE, POSITIONS
from pipeline.measured.reading import Account, read_table
from pipeline.measured.reading.decoding import read_bytes
from pipeline.measured.table import TIME

MOST_LATE_S = 2.0
"""Largest clock offset that is looked for."""


def reflector_columns(number: int) -> tuple[str, ...]:
    """Name the columns of a reflector, counted from 1."""
    return tuple(f"{axis}{number}_m" for axis in "xyz")


class PosesFile(NamedTuple):
    """A file that was read: how, and the hash of its content."""

    account: Account
    sha256: str


class _File(NamedTuple):
    """Rows of a file: encoders, NaN in those of a motion; reflectors; times, NaN in static ones."""

    q_m: FloatArray
    seen_m: FloatArray
    t_s: FloatArray
    is_motion: bool
    read: PosesFile


def read_poses(
    files: Sequence[Path], reflector_count: int, driven: DrivenMotion | None = None
) -> tuple[StaticPoses, list[PosesFile]]:
    """Read poses from files, as `read_table` reads tables; reflectors may have gaps where they were not seen.

    Files without encoders are motions, with a clock of their own each: all are measurements of what was `driven`.

    Raises
    ------
    UsageError
        When anything else is in a file, it has columns of more reflectors, or times that are not those of the motion;
        names file, line and column.
    OSError
        When a file cannot be read.
    """
    read = [_read(file, reflector_count, driven) for file in files]
    ends = np.cumsum([len(one.seen_m) for one in read])

    def place(row: int) -> str:
        index = int(np.searchsorted(ends, row, side="right"))
        return read[index].read.account.place(row - (int(ends[index - 1]) if index else 0))

    q, seen, t = (np.concatenate([getattr(one, name) for one in read]) for name in ("q_m", "seen_m", "t_s"))
    timing = None
    if any(one.is_motion for one in read):
        assert driven is not None, "a motion without a run is refused"
        number = np.cumsum([one.is_motion for one in read]) - 1
        motion = [np.full(len(one.t_s), k if one.is_motion else -1) for k, one in zip(number, read, strict=True)]
        timing = Timing(driven, np.concatenate(motion), t)
    return StaticPoses(q, seen, place, timing), [one.read for one in read]


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


def _read(file: Path, count: int, driven: DrivenMotion | None) -> _File:
    data, numbers = read_bytes(file), range(1, count + 1)
    reflectors = tuple(name for number in numbers for name in reflector_columns(number))
    more = reflector_columns(count + 1)
    firsts = (POSITIONS, (TIME,))
    choices = [(*first, *reflectors, *beyond) for first in firsts for beyond in (more, ())]
    table = read_table(data, str(file), choices, reflectors + more)
    if more[0] in table.columns:
        raise UsageError(
            f"{file}: has columns of a reflector {count + 1}, but places of {count} are given.\n"
            f"  What to change: give --reflector-{count + 1} X Y Z, or remove the columns."
        )
    seen = np.column_stack([table.columns[name] for name in reflectors]).reshape(-1, count, 3)
    read = PosesFile(table.account, hashlib.sha256(data).hexdigest())
    if POSITIONS[0] in table.columns:
        q = np.column_stack([table.columns[name] for name in POSITIONS])
        return _File(q, seen, np.full(len(q), np.nan), False, read)
    t = table.columns[TIME]
    if driven is None:
        raise UsageError(
            f"{file}: has times {TIME} instead of encoders: it is of a motion.\n"
            "  What to change: give --run RUN, the run that was driven; or add columns q1_m to q5_m."
        )
    _require_times(t, driven.trajectory.duration_s, table.account)
    return _File(driven.encoders(t), seen, t, True, read)


def _require_times(t_s: FloatArray, duration_s: float, account: Account) -> None:
    """Refuse times that do not increase, or have nothing to do with the motion."""
    if not (later := np.diff(t_s) > 0.0).all():
        row = int(np.argmin(later)) + 1
        raise UsageError(
            f"{account.place(row)}: times in {TIME} must increase from row to row, but {t_s[row]:.9g} follows "
            f"{t_s[row - 1]:.9g}.\n  What to change: sort the rows; give each motion in a file of its own."
        )
    if t_s[0] < -MOST_LATE_S or t_s[-1] > duration_s + MOST_LATE_S:
        unit = "; they look like milliseconds" if t_s[-1] > 20.0 * duration_s else ""
        raise UsageError(
            f"{account.file}: times from {t_s[0]:g} to {t_s[-1]:g} s are not those of the motion, which lasts "
            f"{duration_s:g} s{unit}.\n  What to change: count {TIME} in seconds from about the start of the motion, "
            f"within {MOST_LATE_S:g} s, and remove rows before and after it."
        )
