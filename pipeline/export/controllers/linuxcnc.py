"""Lines for LinuxCNC's halstreamer, and the HAL file that plays them.

A line has five floats, the actuators' positions; the lines are a period apart. halstreamer skips lines that begin with
#; these comments name the period, the unit and the order of the pins.

Before its first line, streamer's pins hold zero. The HAL file therefore puts a selector behind each pin: it holds the
first row until streamer has taken that row out of its FIFO, and passes streamer's pin on from then on, for good. The
FIFO takes the whole motion before it is started, so that it cannot run empty on the way.
"""

import numpy as np

from pipeline.errors import UsageError
from pipeline.export.csv import DECIMALS
from pipeline.export.formats import LengthUnit
from pipeline.export.motion import Motion
from pipeline.export.request import ExportRequest
from pipeline.machine.geometry import ACTUATORS

_PERIOD = "# period_s: "
_PINS = "# pins: "
_UNITS = {LengthUnit.M: "metres", LengthUnit.MM: "millimetres"}
_DEEPEST = 200_000
"""Rows that a FIFO takes here: about 10 MB of shared memory."""


def format_halstreamer(request: ExportRequest) -> str:
    """Write positions in the unit asked for; the time of a line is its number times the period."""
    samples = request.samples
    period = samples.t_s[1] - samples.t_s[0]
    head = [
        f"# halstreamer: loadrt threads period1={_nanoseconds(request)}; loadrt streamer cfg=fffff (see the .hal file)",
        f"{_PERIOD}{float(period)!r}",
        f"{_PINS}{' '.join(ACTUATORS)}, {_UNITS[request.options.length]}",
    ]
    return "\n".join([*head, *(" ".join(row) for row in _rows(request, samples.q_m.tolist()))]) + "\n"


def format_hal(request: ExportRequest) -> str:
    """Write the HAL file: threads, streamer, and the selectors that hold the first row until the motion starts.

    Raises
    ------
    UsageError
        When the motion has more rows than the FIFO takes.
    """
    rows = len(request.samples)
    if rows > _DEEPEST:
        raise UsageError(
            f"{rows:,} rows do not fit into streamer's FIFO, which takes {_DEEPEST:,} here.\n"
            "  What to change: raise --period."
        )
    (first,) = _rows(request, request.samples.q_m[:1].tolist())
    joints = list(zip(ACTUATORS, request.joint_names, first, strict=True))
    unit, period = _UNITS[request.options.length], _nanoseconds(request)
    return "\n".join(
        [
            f"# Plays {rows} rows of five positions in {unit}, {period} ns apart.",
            "#   1. Load this file. The signals below hold the first row: move the machine there, then switch on.",
            "#   2. halstreamer FILE     fills the FIFO and returns; streamer.0.curr-depth is then the number of rows.",
            "#   3. halcmd sets tau-go 1 starts; after the last row the signals keep it.",
            "# tau-go 0 on the way stops at once, without braking: for that use the machine's own stop.",
            "# An underrun (streamer.0.underruns above 0 before the end) freezes the signals. It cannot happen if the",
            "# FIFO was filled first; if it does: switch off, and begin at 1.",
            "# In a machine's configuration leave out `loadrt threads` and `start`, and put the name of its own",
            "# thread, which has to have this very period, in place of tau-thread.",
            f"loadrt threads name1=tau-thread period1={period}",
            f"loadrt streamer depth={rows + 1} cfg=fffff",
            f"loadrt mux2 count={len(joints)}",
            "loadrt not count=1",
            "loadrt and2 count=2",
            "loadrt or2 count=1",
            "",
            "# In this order: whether to go on, once per period; a row; whether there was one; the selectors.",
            "addf and2.1 tau-thread",
            "addf streamer.0 tau-thread",
            "addf not.0 tau-thread",
            "addf and2.0 tau-thread",
            "addf or2.0 tau-thread",
            *(f"addf mux2.{k} tau-thread" for k in range(len(joints))),
            "",
            "setp streamer.0.enable 0",
            "net tau-go and2.1.in0 and2.1.in1",
            "net tau-run and2.1.out => streamer.0.enable and2.0.in0",
            "net tau-empty streamer.0.empty => not.0.in",
            "net tau-row not.0.out => and2.0.in1",
            "net tau-started and2.0.out => or2.0.in0",
            f"net tau-playing or2.0.out => or2.0.in1 {' '.join(f'mux2.{k}.sel' for k in range(len(joints)))}",
            "",
            "# Commands of the joints: net NAME-command => the input of its drive.",
            *(
                line
                for k, (actuator, joint, value) in enumerate(joints)
                for line in (
                    f"setp mux2.{k}.in0 {value}",
                    f"net {actuator}-streamed streamer.0.pin.{k} => mux2.{k}.in1",
                    f"net {actuator}-command mux2.{k}.out  # {joint}",
                )
            ),
            "",
            "start",
            "",
        ]
    )


def _nanoseconds(request: ExportRequest) -> int:
    return round(request.samples.period_s * 1e9)


def _rows(request: ExportRequest, q_m: list[list[float]]) -> list[list[str]]:
    unit = request.options.length.metres
    decimals = max(DECIMALS + round(np.log10(unit)), request.needed_decimals(unit))
    return [[f"{value / unit:.{decimals}f}" for value in row] for row in q_m]


def read_halstreamer(text: str) -> Motion:
    """Read the lines back, and period and unit from the comments.

    Raises
    ------
    ValueError
        When there is no period, or a line does not have five numbers; names the line.
    """
    period, rows, unit = None, [], 1.0
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith(_PERIOD):
            period = float(line.removeprefix(_PERIOD))
        if line.startswith(_PINS) and line.endswith(_UNITS[LengthUnit.MM]):
            unit = LengthUnit.MM.metres
        if line.startswith("#") or not line.strip():
            continue
        values = line.split()
        if len(values) != len(ACTUATORS):
            raise ValueError(f"line {number} has {len(values)} values for {len(ACTUATORS)} pins")
        rows.append([unit * float(value) for value in values])
    if period is None:
        raise ValueError("no comment states the period")
    return Motion(period * np.arange(len(rows), dtype=float), np.array(rows).reshape(-1, len(ACTUATORS)))
