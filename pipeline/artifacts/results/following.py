"""The proven following errors over s as a table: what may trip a drive, and where."""

from pipeline.arrays import FloatArray
from pipeline.artifacts.layout import FOLLOWING_CSV
from pipeline.certify.following.steps import FollowingProfile, at_ends
from pipeline.export.csv import format_csv
from pipeline.machine.geometry import ACTUATORS

LIMIT_COLUMNS = tuple(f"e{k + 1}_m" for k in range(len(ACTUATORS)))
"""Largest errors of the actuators within the limits."""
BRANCH_COLUMNS = tuple(f"branch_e{k + 1}_m" for k in range(len(ACTUATORS)))
"""Largest errors of the actuators on the branch, whatever limits are broken."""


def following_files(profile: FollowingProfile, t_s: FloatArray | None) -> dict[str, bytes]:
    """Write `following.csv`: a row where the errors change, with those of the neighbour that has the smaller ones.

    Between two rows, straight lines are below what is proven. Times (n + 1,) are a column if they are known.
    """
    columns = {"s": profile.s} | ({} if t_s is None else {"t_s": t_s})
    for names, steps in ((LIMIT_COLUMNS, profile.within_limits_m), (BRANCH_COLUMNS, profile.on_branch_m)):
        columns |= dict.fromkeys(names, at_ends(steps))
    return {FOLLOWING_CSV: format_csv(columns).encode()}
