"""Lines for LinuxCNC's halstreamer: five floats each, the actuators' positions, one line per period.

The streamer component is to be loaded with cfg=fffff and its function added to a thread of the same period. Lines that
begin with # are comments, which halstreamer skips; period, unit and order of the pins are told there.
"""

import numpy as np

from pipeline.export.motion import Motion
from pipeline.machine.geometry import ACTUATORS

_PERIOD = "# period_s: "


def format_halstreamer(motion: Motion, decimals: int) -> str:
    """Write positions in metres; time is the number of the line times the period."""
    period = motion.t_s[1] - motion.t_s[0]
    head = [
        "# halstreamer: loadrt streamer cfg=fffff depth=4000; the thread's period is that of the file",
        f"{_PERIOD}{float(period)!r}",
        f"# pins: {' '.join(ACTUATORS)}, metres",
    ]
    lines = [" ".join(f"{value:.{decimals}f}" for value in row) for row in motion.q_m.tolist()]
    return "\n".join([*head, *lines]) + "\n"


def read_halstreamer(text: str) -> Motion:
    """Read the lines back; the period is in the comments.

    Raises
    ------
    ValueError
        When the period is not told, or a line has not five numbers; names the line.
    """
    period, rows = None, []
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith(_PERIOD):
            period = float(line.removeprefix(_PERIOD))
        if line.startswith("#") or not line.strip():
            continue
        values = line.split()
        if len(values) != len(ACTUATORS):
            raise ValueError(f"line {number} has {len(values)} values for {len(ACTUATORS)} pins")
        rows.append([float(value) for value in values])
    if period is None:
        raise ValueError("the period is not told in any comment")
    return Motion(period * np.arange(len(rows), dtype=float), np.array(rows).reshape(-1, len(ACTUATORS)))
