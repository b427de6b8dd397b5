"""What the page says, as HTML: everything that comes from files or errors is escaped."""

import shlex
from collections.abc import Iterable, Mapping
from html import escape
from math import inf
from pathlib import Path

from pipeline.config import BoxConfig, Config, PoseConfig
from pipeline.limits import Reading
from pipeline.show.posture import Posture

_RED, _AMBER, _GREEN = "#c2410c", "#b45309", "#15803d"
_NARROW = 0.1
"""Room below which a limit is near."""
_BAR_PX = 44


def verdict_html(posture: Posture) -> str:
    """Say whether the pose could be used, why not, and which limit is nearest."""
    if posture.refusals:
        where = "" if posture.reached else " The machine stays where it was."
        items = "".join(f"<li>{escape(reason)}</li>" for reason in posture.refusals)
        title = "Out of reach." if not posture.reached else "Not allowed here."
        return _box(_RED, f"<b>{title}</b>{where}<ul style='margin:2px 0 0 16px;padding:0'>{items}</ul>")
    return _box(_colour(posture.nearest), f"<b>Within all limits.</b> {nearest_words(posture.nearest)}")


def moving_html(title: str, readings: Iterable[Reading]) -> str:
    """Say what a played motion keeps at an instant."""
    nearest = min(readings, key=lambda reading: reading.room)
    return _box(_colour(nearest), f"<b>{escape(title)}</b> {nearest_words(nearest)}")


def nearest_words(reading: Reading) -> str:
    """Name the limit with the least room, and its margin."""
    unit = f" {reading.unit}" if reading.unit else ""
    return f"Nearest limit: <b>{escape(reading.name)}</b>, {number(reading.margin)}{escape(unit)} left."


def readings_html(readings: Iterable[Reading]) -> str:
    """Tabulate what every limit reads, the nearest first, with a bar for its room."""
    rows = "".join(_row(reading) for reading in sorted(readings, key=lambda reading: reading.room))
    head = "".join(
        f"<th style='text-align:{side};font-weight:600'>{name}</th>"
        for name, side in (
            ("limit", "left"),
            ("value", "right"),
            ("allowed", "left"),
            ("margin", "right"),
            ("", "left"),
        )
    )
    return (
        "<div style='padding:0 8px 8px;overflow-x:auto'><table class='gantry-readings' style='border-collapse:collapse;"
        f"width:100%;font-size:11.5px;line-height:1.5;font-variant-numeric:tabular-nums'><tr>{head}</tr>{rows}</table></div>"
    )


def _row(reading: Reading) -> str:
    colour = _colour(reading)
    width = round(_BAR_PX * min(max(reading.room, 0.0), 1.0))
    bar = (
        f"<span style='display:inline-block;width:{_BAR_PX}px;height:7px;border-radius:4px;background:#8884'>"
        f"<span style='display:block;width:{width}px;height:7px;border-radius:4px;background:{colour}'></span></span>"
    )
    unit = f" {reading.unit}" if reading.unit else ""
    cells = (
        (
            "left;white-space:normal;min-width:100px",
            f"<span title='{escape(reading.key, quote=True)}'>{escape(reading.name)}</span>",
        ),
        ("right", f"{reading.value:.4f}{escape(unit)}"),
        ("left", escape(reading.allowed)),
        ("right", f"<span style='color:{colour}'>{number(reading.margin)}</span>"),
        ("left", bar if reading.margin < inf else ""),
    )
    inner = "".join(
        f"<td style='white-space:nowrap;padding-right:6px;text-align:{side}'>{text}</td>" for side, text in cells
    )
    return f"<tr style='border-top:1px solid #8883'>{inner}</tr>"


def pose_html(posture: Posture) -> str:
    """State the pose in which the machine stands, with the dependent angle, kappa and the sign of det H."""
    pose, samples = posture.samples.pose[0], posture.samples
    degrees = [f"{value * 57.29577951308232:.2f}°" for value in pose[3:]]
    return _line(
        f"x {pose[0]:.4f}, y {pose[1]:.4f}, z {pose[2]:.4f} m; rx {degrees[0]}, ry {degrees[1]}, rz {degrees[2]}; "
        f"kappa <b>{samples.kappa[0]:.3f}</b>, sign of det H {samples.det_sign[0]:+.0f}"
    )


def modes_html(modes: Mapping[str, tuple[float, float]], mode: str) -> str:
    """List the working modes that reach the pose, with kappa and the sign of det H."""
    if not modes:
        return _line("No working mode reaches this pose.")
    parts = [f"{name} ({kappa:.0f}, {'+' if sign > 0.0 else '−'})" for name, (kappa, sign) in modes.items()]
    parts = [f"<b>{part}</b>" if part.startswith(mode) else part for part in parts]
    return _line(f"Within reach of the arms, limits aside (kappa, sign of det H): {', '.join(parts)}")


def task_html(config: Config, refusals: Iterable[str]) -> str:
    """List the task, and what `check` says of it."""
    task = config.task
    entries = [("start", pose_words(task.start)), ("goal", pose_words(task.goal))]
    entries += [(name, words) for name, words in task_entries(config)]
    rows = "".join(
        f"<tr><td style='padding-right:8px'><b>{escape(a)}</b></td><td>{escape(b)}</td></tr>" for a, b in entries
    )
    found = list(refusals)
    items = "".join(f"<li>{escape(text)}</li>" for text in found)
    verdict = (
        _box(_RED, f"<b>check refuses this task:</b><ul style='margin:2px 0 0 16px;padding:0'>{items}</ul>")
        if found
        else _box(_GREEN, "<b>check accepts this task.</b> Whether there is a route, planning finds out.")
    )
    return f"<div style='padding:0 8px;font-size:12px'><table>{rows}</table></div>{verdict}"


def task_entries(config: Config) -> list[tuple[str, str]]:
    """Name what is visited and avoided by its key, with its values."""
    visits = []
    for k, visit in enumerate(config.task.visit):
        words = pose_words(visit.pose) if visit.pose is not None else box_words(visit.box) if visit.box else ""
        visits.append((f"visit[{k}]", words))
    return visits + [(f"avoid[{k}]", box_words(box)) for k, box in enumerate(config.task.avoid)]


def pose_words(pose: PoseConfig) -> str:
    """State a pose."""
    return f"{pose.mode} at x {pose.x_m:g}, y {pose.y_m:g}, z {pose.z_m:g} m, rx {pose.rx_deg:g}°, rz {pose.rz_deg:g}°"


def box_words(box: BoxConfig) -> str:
    """State the intervals of a box."""
    given = {key: ends for key, ends in box.model_dump().items() if ends is not None}
    return ", ".join(f"{key} {ends[0]:g} to {ends[1]:g}" for key, ends in given.items())


def next_html(run: str, folder: Path, timed: bool) -> str:
    """Say where the motion is for the controller, or how to get there; `run` is the command that plans all of it."""
    if not timed:
        return _line(f"Next, for a CSV: plan up to <i>trajectory</i> here, or type <code>{escape(run)}</code>")
    export = f"gantry-tau export {shlex.quote(str(folder))} --format csv --output motion.csv"
    return _line(
        f"For the controller: <code>{escape(str(folder / 'trajectory.csv'))}</code>; with other columns or another "
        f"period, <code>{escape(export)}</code>. Figures and report: <code>{escape(run)}</code>"
    )


def message_html(text: str, wrong: bool = False) -> str:
    """Show a message with its lines as they are."""
    return _box(_RED if wrong else "#2563eb", escape(text).replace("\n", "<br>"))


def note_html(text: str) -> str:
    """Show a remark in small letters."""
    return f"<div style='padding:2px 8px;font-size:11.5px;line-height:1.4;opacity:0.8'>{escape(text)}</div>"


def number(value: float) -> str:
    """Format a number as `check` does: with four decimals; a margin without a limit is none."""
    return "-" if value == inf else f"{value:.4f}"


def _colour(reading: Reading) -> str:
    return _RED if reading.room < 0.0 else _AMBER if reading.room < _NARROW else _GREEN


def _box(colour: str, inner: str) -> str:
    style = f"border-left:4px solid {colour};background:{colour}18;padding:6px 8px;margin:4px 8px;font-size:12.5px"
    return f"<div style='{style};line-height:1.4;overflow-wrap:anywhere'>{inner}</div>"


def _line(inner: str) -> str:
    return f"<div style='padding:2px 8px;font-size:12px;line-height:1.45;overflow-wrap:anywhere'>{inner}</div>"
