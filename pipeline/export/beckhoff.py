"""A table for PLC programs on Beckhoff controllers, in a dialect of our own: there is no official one.

Semicolons between values, decimal points, CRLF at line ends, ASCII. The first line names the columns, whose suffix is
the unit: Time_ms, then per actuator Position_mm, Velocity_mm_s and Acceleration_mm_s2, the units of NC axes. A row per
period, the first at time zero.
"""

from collections.abc import Sequence

import numpy as np

from pipeline.export.motion import Motion

_MM = 1_000.0
_QUANTITIES = ("Position_mm", "Velocity_mm_s", "Acceleration_mm_s2")
_TIME_DECIMALS = 6


def format_beckhoff(motion: Motion, joint_names: Sequence[str], decimals: int) -> str:
    """Write the table, values in millimetres with a fixed number of decimals.

    Raises
    ------
    ValueError
        When the motion has no velocities or accelerations.
    """
    if motion.qd_mps is None or motion.qdd_mps2 is None:
        raise ValueError("the table needs velocities and accelerations")
    head = ["Time_ms", *(f"{joint}.{quantity}" for joint in joint_names for quantity in _QUANTITIES)]
    values = _MM * np.stack([motion.q_m, motion.qd_mps, motion.qdd_mps2], axis=2).reshape(len(motion.t_s), -1)
    rounded = np.where(np.abs(values) <= 0.5 * 10.0**-decimals, 0.0, values)
    lines = [
        ";".join([f"{t:.{_TIME_DECIMALS}f}", *(f"{value:.{decimals}f}" for value in row)])
        for t, row in zip((_MM * motion.t_s).tolist(), rounded.tolist(), strict=True)
    ]
    return "\r\n".join([";".join(head), *lines]) + "\r\n"


def read_beckhoff(text: str) -> tuple[Motion, tuple[str, ...]]:
    """Read the table back: the motion in metres, and the names of the joints.

    Raises
    ------
    ValueError
        When lines do not end with CRLF, or columns are not those of the dialect.
    """
    head, *lines = text.removesuffix("\r\n").split("\r\n")
    names = head.split(";")
    joints = tuple(name.rsplit(".", 1)[0] for name in names[1 :: len(_QUANTITIES)])
    if names != ["Time_ms", *(f"{joint}.{quantity}" for joint in joints for quantity in _QUANTITIES)]:
        raise ValueError(f"the columns are not those of this dialect: {head!r}")
    table = np.array([[float(value) for value in line.split(";")] for line in lines]) / _MM
    q, qd, qdd = np.moveaxis(table[:, 1:].reshape(len(table), len(joints), len(_QUANTITIES)), 2, 0)
    return Motion(table[:, 0], q, qd, qdd), joints
