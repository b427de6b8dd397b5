"""A trajectory as a CSV table with the columns of `trajectory.csv`, or some of them, in SI or other units."""

import numpy as np

from pipeline.errors import UsageError
from pipeline.export.csv import DECIMALS, format_csv, read_csv
from pipeline.export.formats import LengthUnit
from pipeline.export.motion import Motion
from pipeline.export.request import ExportRequest
from pipeline.export.trajectory_columns import ACCELERATIONS, POSITIONS, VELOCITIES, trajectory_columns
from pipeline.export.units import converted

_MM = 0.001


def format_trajectory_csv(request: ExportRequest) -> str:
    """Write the columns asked for, with the decimals asked for or as many as the period needs.

    Raises
    ------
    UsageError
        When the options name no columns, unknown ones or one twice, or fewer decimals than the period needs.
    """
    options, columns = request.options, trajectory_columns(request.samples)
    wanted = tuple(columns) if options.columns is None else options.columns
    if not wanted:
        raise UsageError(f"--columns names no column; choose from {', '.join(columns)}")
    unknown = [name for name in wanted if name not in columns]
    if unknown:
        raise UsageError(f"there is no column {', '.join(unknown)}; choose from {', '.join(columns)}")
    if len(set(wanted)) < len(wanted):
        raise UsageError(f"--columns names a column twice: {', '.join(wanted)}")
    needed = request.needed_decimals(_MM if options.length is LengthUnit.MM else 1.0)
    if options.decimals is not None and options.decimals < needed:
        raise UsageError(
            f"{options.decimals} decimals are too few: with a period of {request.samples.period_s:g} s, rounding would "
            "show in the accelerations that a controller computes from positions.\n"
            f"  What to change: at least {needed} decimals."
        )
    decimals = max(DECIMALS, needed) if options.decimals is None else options.decimals
    chosen = {name: columns[name] for name in wanted}
    return format_csv(converted(chosen, options.length, options.angle), decimals, options.separator.character)


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
