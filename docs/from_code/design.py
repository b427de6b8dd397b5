"""The table of the study of the machine's dimensions that is kept in git."""

import csv
from pathlib import Path

import numpy as np

from from_code.markdown import literal, table
from pipeline.study.report.pareto import undominated

_STUDY = Path(__file__).parents[2] / "results" / "reference" / "design" / "study.csv"
RATIO, KAPPA = "workspace.volume_ratio", "path.kappa_max"
_FIGURES = {
    RATIO: ("workspace per installation space", "{:.3f}"),
    "workspace.area_ratio": ("area per frame", "{:.3f}"),
    "workspace.volume_m3": ("workspace m³", "{:.2f}"),
    KAPPA: ("largest kappa", "{:.2f}"),
}


def design_table() -> str:
    """List the reference machine, which is the first run, and the designs that no other beats in both objectives."""
    with _STUDY.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    best = sorted(front(rows), key=lambda row: float(row[RATIO]))
    parameters = [name for name in rows[0] if name.startswith("machine.")]
    header = (
        "run",
        *(literal(name.removeprefix("machine.")) for name in parameters),
        *(n for n, _ in _FIGURES.values()),
    )
    return table(header, [_cells(row, parameters) for row in (rows[0], *best)])


def front(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """Keep the runs that count and that no other beats: more workspace, less kappa."""
    counting = [row for row in rows if not row["reason"]]
    costs = np.array([[-float(row[RATIO]), float(row[KAPPA])] for row in counting])
    return [row for row, best in zip(counting, undominated(costs), strict=True) if best]


def _cells(row: dict[str, str], parameters: list[str]) -> tuple[str, ...]:
    number = f"{row['number']}, the reference" if row["number"] == "1" else row["number"]
    values = (f"{float(row[name]):.3f}" for name in parameters)
    return (number, *values, *(form.format(float(row[name])) for name, (_, form) in _FIGURES.items()))
