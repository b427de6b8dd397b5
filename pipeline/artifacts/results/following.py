"""The proven following errors over s as a table: what may trip a drive, and where."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.artifacts.layout import FOLLOWING_CSV
from pipeline.certify.following.steps import FollowingProfile, at_ends, following_profile
from pipeline.certify.recheck import Claim
from pipeline.certify.result import ProvenChain
from pipeline.export.csv import DECIMALS, Column, format_csv, read_csv
from pipeline.machine.geometry import ACTUATORS
from pipeline.retime.result import Trajectory

LIMIT_COLUMNS = tuple(f"e{k + 1}_m" for k in range(len(ACTUATORS)))
"""Largest errors of the actuators within the limits."""
TABLE = "following.csv has the proven errors"
TIMES = "following.csv has the times of the trajectory"
BRANCH_COLUMNS = tuple(f"branch_e{k + 1}_m" for k in range(len(ACTUATORS)))
"""Largest errors of the actuators on the branch, whatever limits are broken."""
_TIME = "t_s"
_FIRST_LINE = 2
"""Line of the file that has the first row."""
_SAME_S = 1e-9
"""How far the trajectory may be from a row's s at its time, which is rounded."""
_AGAIN = "prove it again: gantry-tau certify CONFIG --following --force"


def following_files(profile: FollowingProfile, t_s: FloatArray | None) -> dict[str, bytes]:
    """Write `following.csv`: a row where the errors change, with those of the neighbour that has the smaller ones.

    Between two rows, straight lines are below what is proven. Times (n + 1,) are a column if they are known.
    """
    times = {} if t_s is None else {_TIME: t_s}
    columns = {"s": profile.s} | times | _errors(profile)
    return {FOLLOWING_CSV: format_csv(columns).encode()}


def table_claims(folder: Path, chains: Sequence[ProvenChain], trajectory: Trajectory | None) -> list[Claim]:
    """Verify that the table of a run has the errors of its certificate, whose chains are given, and the right times.

    Nothing is claimed where the certificate has no errors over s and there is no table. Without a trajectory, times are
    not verified.
    """
    file, profile = folder / FOLLOWING_CSV, following_profile(chains)
    if profile is None:
        return [_refused("the certificate has no errors over s")] if file.exists() else []
    try:
        table = read_csv(file.read_text())
    except FileNotFoundError:
        return [_refused(f"{FOLLOWING_CSV} is missing; {_AGAIN}")]
    except (OSError, ValueError) as error:
        return [_refused(f"it is damaged: {error}; {_AGAIN}")]
    wanted = {"s": profile.s} | _errors(profile)
    if {*table} - {_TIME} != {*wanted}:
        return [_refused(f"it has other columns; {_AGAIN}")]
    wrong = next(filter(None, (_difference(name, table[name], one) for name, one in wanted.items())), None)
    if wrong is not None:
        return [_refused(wrong)]
    claims = [Claim(TABLE, verified=True, found=f"{len(profile.s)} rows")]
    return claims if _TIME not in table else [*claims, _time_claim(table[_TIME], profile.s, trajectory)]


def _time_claim(times: Column, s: FloatArray, trajectory: Trajectory | None) -> Claim:
    """Verify that the trajectory is at s (n,) at some times."""
    if times.dtype.kind not in "if":
        row = next(row for row, cell in enumerate(times.tolist()) if not _is_number(cell))
        return Claim(TIMES, verified=False, found=f"line {row + _FIRST_LINE}, {_TIME}: {times[row]} is not a number")
    if trajectory is None:
        kept = np.isfinite(times) & (np.diff(times, prepend=0.0) >= 0.0)
        found = "they increase; there is no trajectory to verify them by"
    else:
        inside = (times >= 0.0) & (times <= trajectory.duration_s + _SAME_S)
        off = np.abs(trajectory.s(np.where(inside, times, 0.0)) - s)
        kept = inside & (off <= _SAME_S)
        found = f"{len(s)} rows"
    if not kept.all():
        row = int(np.argmin(kept))
        found = f"line {row + _FIRST_LINE}, {_TIME}: at {times[row]:g} s the trajectory is not at s = {s[row]:.6g}"
    return Claim(TIMES, verified=bool(kept.all()), found=found)


def _refused(found: str) -> Claim:
    return Claim(TABLE, verified=False, found=found)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _errors(profile: FollowingProfile) -> dict[str, FloatArray]:
    within, branch = at_ends(profile.within_limits_m), at_ends(profile.on_branch_m)
    return dict.fromkeys(LIMIT_COLUMNS, within) | dict.fromkeys(BRANCH_COLUMNS, branch)


def _difference(name: str, column: Column, wanted: FloatArray) -> str | None:
    """Name the first line that has another value, rounded to its decimals; None if there is none."""
    if column.shape != wanted.shape:
        return f"it has {len(column)} rows, and {len(wanted)} are proven"
    if column.dtype.kind not in "if":
        return f"{name} holds something other than numbers"
    same = np.isclose(column, wanted, rtol=0.0, atol=10.0**-DECIMALS, equal_nan=True)
    if same.all():
        return None
    row = int(np.argmin(same))
    return f"line {row + _FIRST_LINE}, {name}: {column[row]:.12g}; proven {wanted[row]:.12g}"
