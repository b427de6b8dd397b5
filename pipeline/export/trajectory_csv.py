"""A trajectory as a CSV table with the columns of `trajectory.csv`, or some of them, in SI or other units."""

import numpy as np

from pipeline.errors import UsageError
from pipeline.export.csv import DECIMALS, Column, read_csv
from pipeline.export.motion import Motion
from pipeline.export.request import ExportRequest
from pipeline.export.table import format_table
from pipeline.export.trajectory_columns import ACCELERATIONS, JERKS, POSITIONS, VELOCITIES, trajectory_columns


def format_trajectory_csv(request: ExportRequest) -> str:
    """Write the columns asked for, with the decimals asked for or as many as the period needs.

    Raises
    ------
    UsageError
        When the options name no columns, unknown ones or one twice, jerk where accelerations jump, or fewer decimals
        than the period needs.
    """
    options = request.options
    chosen = _chosen(request)
    needed = request.needed_decimals(options.length.metres)
    if options.decimals is not None and options.decimals < needed:
        raise UsageError(
            f"{options.decimals} decimals are too few: with a period of {request.samples.period_s:g} s, rounding would "
            "show in the accelerations that a controller computes from positions.\n"
            f"  What to change: at least {needed} decimals."
        )
    decimals = max(DECIMALS, needed) if options.decimals is None else options.decimals
    return format_table(chosen, decimals, options)


def _chosen(request: ExportRequest) -> dict[str, Column]:
    """Pick the columns asked for: without a wish those of `trajectory.csv`, which has no jerk."""
    columns, wanted = trajectory_columns(request.samples), request.options.columns
    if wanted is None:
        return columns
    names = (*columns, *JERKS)
    if not wanted:
        raise UsageError(f"--columns names no column; choose from {', '.join(names)}")
    if unknown := [name for name in wanted if name not in names]:
        raise UsageError(f"there is no column {', '.join(unknown)}; choose from {', '.join(names)}")
    if len(set(wanted)) < len(wanted):
        raise UsageError(f"--columns names a column twice: {', '.join(wanted)}")
    if request.jerk_mps3 is not None:
        columns |= dict(zip(JERKS, request.jerk_mps3.T, strict=True))
    elif jerks := [name for name in wanted if name in JERKS]:
        raise UsageError(
            f"there is no {', '.join(jerks)}: accelerations of this motion jump.\n"
            "  What to change: limit jerk (machine.limits, retime.jerk: on)."
        )
    return {name: columns[name] for name in wanted}


def read_trajectory_csv(text: str) -> Motion:
    """Read the motion back from a table in SI units, separated by commas.

    Raises
    ------
    ValueError
        When the table is damaged, or a column is missing.
    """
    table = read_csv(text)
    if missing := [name for name in ("t_s", *POSITIONS, *VELOCITIES, *ACCELERATIONS) if name not in table]:
        raise ValueError(f"there is no column {', '.join(missing)}")
    q, qd, qdd = (np.stack([table[name] for name in names], axis=1) for names in (POSITIONS, VELOCITIES, ACCELERATIONS))
    return Motion(table["t_s"], q, qd, qdd)
