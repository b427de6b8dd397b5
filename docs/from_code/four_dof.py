"""The table of the study of 4-DOF machines that is kept in git."""

import csv
import json
from pathlib import Path

from from_code.markdown import plain, table

_STUDY = Path(__file__).parents[2] / "results" / "reference" / "four_dof" / "study.csv"
_HEADER = (
    "locked",
    "tilt limit deg",
    "direction",
    "what came of it",
    "largest kappa",
    "kappa integral",
    "duration s",
    "proven tolerance mm",
)


def four_dof_table() -> str:
    """List every run of the study: what is locked, how far the other axis may tilt, and what came of it."""
    with _STUDY.open(encoding="utf-8") as file:
        return table(_HEADER, [_cells(row) for row in csv.DictReader(file)])


def _cells(row: dict[str, str]) -> tuple[str, ...]:
    (locked,) = json.loads(row["task.locked_axes"])
    direction = f"{row['task.start.mode']} to {row['task.goal.mode']}"
    ended = "certified" if row["status"] == "done" else plain(row["reason"])
    figures = (
        _number(row["path.kappa_max"], "{:.1f}"),
        _number(row["path.kappa_integral"], "{:.0f}"),
        _number(row["trajectory.duration_s"], "{:.2f}"),
        _number(row["certificate.tolerance_m"], "{:.2f}", 1e3),
    )
    return (locked, f"{float(row['task.tilt_max_deg']):g}", direction, ended, *figures)


def _number(text: str, form: str, scale: float = 1.0) -> str:
    return form.format(scale * float(text)) if text else ""
