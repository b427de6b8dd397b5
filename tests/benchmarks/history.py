"""What whole runs took, by date: a table and a picture of all files that `whole_runs` has written."""

import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from tests.benchmarks.report import table

_COLOURS = {"agder": "#0072B2", "quick": "#D55E00", "fast": "#009E73"}
_STAGES = ("regions", "route", "refine", "certify", "retime", "figures")


def read_history(folder: Path) -> dict[str, dict[str, Any]]:
    """Read the file of every date, in their order."""
    return {file.stem: json.loads(file.read_text(encoding="utf-8")) for file in sorted(folder.glob("*.json"))}


def runs_page(history: dict[str, dict[str, Any]]) -> str:
    """Write the page: the last date in full, beside what it was compared with, and all dates in short."""
    date, last = list(history.items())[-1]
    parts = [
        "# Whole runs",
        "Written by `make bench-runs` (a part of `make bench`), from one file per date in `history`. Medians of "
        f"{last['repeats']} runs into empty folders; processor time is that of all processes of a run, memory that of "
        "the largest.",
        f"On {date}: {last['host']['cpu']}, {last['host']['cores']} cores, load {last['host']['load_before']:.1f} "
        "before the start.",
        _runs(last),
        "Seconds of every stage. Figures are drawn by two processes, from the first stage on; their seconds are those "
        "that are left at the end.",
        _stages(last),
        f"`import pipeline` takes {last['start']['import_s']:.2f} s, "
        f"`gantry-tau --help` {last['start']['help_s']:.2f} s.",
        "## By date",
        "![Seconds of whole runs over the dates at which they were measured](history/runs.png)",
        "Open circles are what a run was compared with, on the same day.",
        _dates(history),
    ]
    return "\n\n".join(parts) + "\n"


def _runs(last: dict[str, Any]) -> str:
    before = last.get("before", {}).get("runs", {})
    rows = []
    for name, run in last["runs"].items():
        cells = [name, f"{run['wall_s']:.1f}", f"{run['cpu_s']:.1f}", f"{run['peak_mb']:.0f}"]
        if before:
            old = before[name]
            cells += [f"{old['wall_s']:.1f}", f"{old['cpu_s']:.1f}", f"{old['peak_mb']:.0f}"]
            cells += [f"{run['wall_s'] / old['wall_s']:.2f}", f"{run['cpu_s'] / old['cpu_s']:.2f}"]
        rows.append(cells)
    head = ["configuration", "seconds", "processor s", "MB"]
    if before:
        head += ["before: seconds", "processor s", "MB", "ratio of seconds", "of processor s"]
    return table(head, rows)


def _stages(last: dict[str, Any]) -> str:
    rows = []
    for when, runs in (("", last["runs"]), (", before", last.get("before", {}).get("runs", {}))):
        rows += [
            (f"{name}{when}", *(f"{run['stages'].get(stage, 0.0):.2f}" for stage in _STAGES))
            for name, run in runs.items()
        ]
    return table(("configuration", *_STAGES), rows)


def _dates(history: dict[str, dict[str, Any]]) -> str:
    names = _names(history)
    rows = [
        (date, *(_seconds(one, name) for name in names), one["host"]["versions"]["python"])
        for date, one in history.items()
    ]
    return table(("date", *(f"{name}: seconds (processor s)" for name in names), "Python"), rows)


def _seconds(one: dict[str, Any], name: str) -> str:
    run = one["runs"].get(name)
    return "-" if run is None else f"{run['wall_s']:.1f} ({run['cpu_s']:.1f})"


def _names(history: dict[str, dict[str, Any]]) -> Sequence[str]:
    return sorted({name for one in history.values() for name in one["runs"]})


def runs_picture(history: dict[str, dict[str, Any]]) -> bytes:
    """Draw seconds over dates: whole runs as lines, processor time dashed; what came before as an open circle."""
    figure = Figure(figsize=(6.0, 3.0), dpi=150, layout="constrained")
    axes = figure.subplots()
    dates = list(history)
    for name in _names(history):
        known = [(date, one["runs"][name]) for date, one in history.items() if name in one["runs"]]
        for key, style in (("wall_s", "o-"), ("cpu_s", "o--")):
            axes.plot(
                [dates.index(date) for date, _ in known],
                [run[key] for _, run in known],
                style,
                color=_COLOURS.get(name, "black"),
                alpha=1.0 if key == "wall_s" else 0.5,
                label=name if key == "wall_s" else f"{name}, processor time",
                markersize=4.0,
            )
        for date, one in history.items():
            if name in (before := one.get("before", {}).get("runs", {})):
                axes.plot(dates.index(date), before[name]["wall_s"], "o", mfc="none", color=_COLOURS.get(name, "black"))
    axes.set_xticks(range(len(dates)), dates)
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel("seconds of a run")
    axes.margins(x=0.2)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=7)
    picture = io.BytesIO()
    figure.savefig(picture, format="png")
    return picture.getvalue()
