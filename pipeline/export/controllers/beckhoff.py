"""A table for PLC programs on Beckhoff controllers: the CSV that Beckhoff documents for its PLC functions.

Values are separated by semicolons, with decimal points, every record ends with CRLF, ASCII throughout. The first line
names the columns with their units: Time_ms, then per actuator Pos_mm, Vel_mmps and Acc_mmps2, the units of NC axes.
There is a row per period, the first at time zero. FB_FileGets reads lines of 255 characters: there is no longer one.
"""

import numpy as np

from pipeline.errors import UsageError
from pipeline.export.csv import DECIMALS
from pipeline.export.motion import Motion
from pipeline.export.request import ExportRequest

_MM = 1_000.0
_QUANTITIES = ("Pos_mm", "Vel_mmps", "Acc_mmps2")
_TIME_DECIMALS = 6
_LONGEST_LINE = 255
"""Characters of a T_MaxString, the longest text that FB_FileGets returns: what is beyond becomes another line."""


def format_beckhoff(request: ExportRequest) -> str:
    """Write the table, values in millimetres with a fixed number of decimals.

    Raises
    ------
    UsageError
        When a line would be longer than the PLC reads.
    """
    samples, decimals = request.samples, max(DECIMALS - 3, request.needed_decimals(1.0 / _MM))
    head = ";".join(["Time_ms", *(f"{joint}.{quantity}" for joint in request.joint_names for quantity in _QUANTITIES)])
    _require_short(head, "the header", "Shorten export.joint_names.")
    values = _MM * np.stack([samples.q_m, samples.qd_mps, samples.qdd_mps2], axis=2).reshape(len(samples), -1)
    rounded = np.where(np.abs(values) <= 0.5 * 10.0**-decimals, 0.0, values)
    lines = [
        ";".join([f"{t:.{_TIME_DECIMALS}f}", *(f"{value:.{decimals}f}" for value in row)])
        for t, row in zip((_MM * samples.t_s).tolist(), rounded.tolist(), strict=True)
    ]
    longest = max(range(len(lines)), key=lambda row: len(lines[row]))
    _require_short(lines[longest], f"row {longest}", "Raise --period: fewer decimals are needed then.")
    return "\r\n".join([head, *lines]) + "\r\n"


def _require_short(line: str, what: str, advice: str) -> None:
    if len(line) > _LONGEST_LINE:
        raise UsageError(
            f"{what} would have {len(line)} characters; FB_FileGets reads {_LONGEST_LINE} of a line.\n"
            f"  What to change: {advice}"
        )


def read_beckhoff(text: str) -> Motion:
    """Read the table back: the motion in metres, and the names of the joints.

    Raises
    ------
    ValueError
        When lines do not end with CRLF, or the columns are not those of this dialect.
    """
    head, *lines = text.removesuffix("\r\n").split("\r\n")
    names = head.split(";")
    joints = tuple(name.rsplit(".", 1)[0] for name in names[1 :: len(_QUANTITIES)])
    if names != ["Time_ms", *(f"{joint}.{quantity}" for joint in joints for quantity in _QUANTITIES)]:
        raise ValueError(f"the columns are not those of this dialect: {head!r}")
    table = np.array([[float(value) for value in line.split(";")] for line in lines]) / _MM
    q, qd, qdd = np.moveaxis(table[:, 1:].reshape(len(table), len(joints), len(_QUANTITIES)), 2, 0)
    return Motion(table[:, 0], q, qd, qdd, joints)
