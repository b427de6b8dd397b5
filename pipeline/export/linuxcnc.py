"""Lines for LinuxCNC's halstreamer: five floats each, the actuators' positions, one line per period.

Load the streamer component with cfg=fffff and add its function to a thread of the same period. halstreamer skips lines
that begin with #; these comments name the period, the unit and the order of the pins.
"""

import numpy as np

from pipeline.export.csv import DECIMALS
from pipeline.export.motion import Motion
from pipeline.export.request import ExportRequest
from pipeline.machine.geometry import ACTUATORS

_PERIOD = "# period_s: "


def format_halstreamer(request: ExportRequest) -> str:
    """Write positions in metres; the time of a line is its number times the period."""
    samples, decimals = request.samples, max(DECIMALS, request.needed_decimals())
    period = samples.t_s[1] - samples.t_s[0]
    head = [
        "# halstreamer: loadrt streamer cfg=fffff depth=4000; the thread's period is that of the file",
        f"{_PERIOD}{float(period)!r}",
        f"# pins: {' '.join(ACTUATORS)}, metres",
    ]
    lines = [" ".join(f"{value:.{decimals}f}" for value in row) for row in samples.q_m.tolist()]
    return "\n".join([*head, *lines]) + "\n"


def read_halstreamer(text: str) -> Motion:
    """Read the lines back, and the period from the comments.

    Raises
    ------
    ValueError
        When there is no period, or a line does not have five numbers; names the line.
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
        raise ValueError("no comment states the period")
    return Motion(period * np.arange(len(rows), dtype=float), np.array(rows).reshape(-1, len(ACTUATORS)))
