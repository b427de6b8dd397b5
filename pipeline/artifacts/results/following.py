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

LIMIT_COLUMNS = tuple(f"e{k + 1}_m" for k in range(len(ACTUATORS)))
"""Largest errors of the actuators within the limits."""
TABLE = "following.csv has the proven errors"
BRANCH_COLUMNS = tuple(f"branch_e{k + 1}_m" for k in range(len(ACTUATORS)))
"""Largest errors of the actuators on the branch, whatever limits are broken."""


def following_files(profile: FollowingProfile, t_s: FloatArray | None) -> dict[str, bytes]:
    """Write `following.csv`: a row where the errors change, with those of the neighbour that has the smaller ones.

    Between two rows, straight lines are below what is proven. Times (n + 1,) are a column if they are known.
    """
    times = {} if t_s is None else {"t_s": t_s}
    columns = {"s": profile.s} | times | _errors(profile)
    return {FOLLOWING_CSV: format_csv(columns).encode()}


def table_claims(folder: Path, chains: Sequence[ProvenChain]) -> list[Claim]:
    """Verify that the table of a run, if there is one, has the errors of its certificate, whose chains are given."""
    if not (file := folder / FOLLOWING_CSV).exists():
        return []
    profile = following_profile(chains)
    if profile is None:
        return [Claim(TABLE, verified=False, found="the certificate has no errors over s")]
    wanted = {"s": profile.s} | _errors(profile)
    try:
        table = read_csv(file.read_text())
        right = {*table} - {"t_s"} == {*wanted} and all(_same(table[name], one) for name, one in wanted.items())
    except (OSError, ValueError):
        return [Claim(TABLE, verified=False, found="it is damaged")]
    return [Claim(TABLE, verified=right, found=f"{len(profile.s)} rows" if right else "other errors are proven")]


def _errors(profile: FollowingProfile) -> dict[str, FloatArray]:
    within, branch = at_ends(profile.within_limits_m), at_ends(profile.on_branch_m)
    return dict.fromkeys(LIMIT_COLUMNS, within) | dict.fromkeys(BRANCH_COLUMNS, branch)


def _same(column: Column, wanted: FloatArray) -> bool:
    """Return whether a column has some values, rounded to its decimals."""
    if column.shape != wanted.shape or column.dtype.kind not in "if":
        return False
    return np.allclose(column, wanted, rtol=0.0, atol=10.0**-DECIMALS, equal_nan=True)
