"""A PVT table: time, then position and velocity of every axis, between which controllers drive cubics.

Columns are the time, `t_s` since the start or `dt_s` since the row before (zero in the first row), and per joint
`<joint>_m` and `<joint>_mps`.
"""

import numpy as np

from pipeline.export.csv import DECIMALS, Column, read_csv
from pipeline.export.formats import Times
from pipeline.export.motion import Motion
from pipeline.export.request import ExportRequest
from pipeline.export.table import format_table

_TIME = {Times.ABSOLUTE: "t_s", Times.RELATIVE: "dt_s"}
_SUFFIXES = ("_m", "_mps")


def format_pvt(request: ExportRequest) -> str:
    """Write the table with as many decimals as the period needs.

    Raises
    ------
    UsageError
        When other names are given for the columns, but not one for each.
    """
    samples, options = request.samples, request.options
    t = samples.t_s if options.times is Times.ABSOLUTE else np.diff(samples.t_s, prepend=samples.t_s[0])
    columns: dict[str, Column] = {_TIME[options.times]: t}
    for k, joint in enumerate(request.joint_names):
        columns |= {joint + "_m": samples.q_m[:, k], joint + "_mps": samples.qd_mps[:, k]}
    return format_table(columns, max(DECIMALS, request.needed_decimals(options.length.metres)), options)


def read_pvt(text: str) -> Motion:
    """Read the motion back from a table in metres, separated by commas, with its own column names.

    Raises
    ------
    ValueError
        When the table is damaged, or its columns are others.
    """
    table = read_csv(text)
    time, *names = table
    joints = tuple(name.removesuffix("_m") for name in names[::2])
    if time not in _TIME.values() or names != [joint + suffix for joint in joints for suffix in _SUFFIXES]:
        raise ValueError(f"not a table of times, positions and velocities: {', '.join(table)}")
    t = table[time] if time == _TIME[Times.ABSOLUTE] else np.cumsum(table[time])
    q, qd = (np.stack([table[joint + suffix] for joint in joints], axis=1) for suffix in _SUFFIXES)
    return Motion(t, q, qd, joint_names=joints)
