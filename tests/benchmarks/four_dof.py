"""The picture of the study of 4-DOF machines: `python -m tests.benchmarks.four_dof STUDY.csv PICTURE`."""

import csv
import json
import sys
from pathlib import Path

from matplotlib.figure import Figure

from pipeline.figures import style

PANELS = (
    ("path.kappa_max", "largest kappa", 1.0),
    ("trajectory.duration_s", "duration (s)", 1.0),
    ("certificate.tolerance_m", "proven tolerance (mm)", 1e3),
)
COLOURS = {"rx": style.BLUE, "rz": style.ORANGE}


@style.styled
def four_dof_figure(rows: list[dict[str, str]]) -> Figure:
    """Draw figures over the tilt limit, by the axis that is locked; crosses are limits without a certified motion."""
    figure = Figure(figsize=(2 * style.WIDTH_IN, 0.62 * style.WIDTH_IN), layout="constrained")
    axes = figure.subplots(1, len(PANELS))
    for place, (column, label, scale) in zip(axes, PANELS, strict=True):
        for number, (locked, colour) in enumerate(COLOURS.items()):
            mine = [row for row in rows if json.loads(row["task.locked_axes"]) == [locked]]
            done = [row for row in mine if row["status"] == "done"]
            none = sorted(
                {float(row["task.tilt_max_deg"]) for row in mine} - {float(r["task.tilt_max_deg"]) for r in done}
            )
            for start, marker in (("LLL", "o"), ("RRR", "s")):
                way = [row for row in done if row["task.start.mode"] == start]
                tilts, values = [float(row["task.tilt_max_deg"]) for row in way], [float(row[column]) for row in way]
                name = f"{locked} locked, from {start}"
                place.plot(
                    tilts,
                    [scale * value for value in values],
                    marker=marker,
                    color=colour,
                    markerfacecolor="none",
                    label=name,
                )
            place.plot(
                none, [0.04 + 0.06 * number] * len(none), "x", color=colour, transform=place.get_xaxis_transform()
            )
        place.set_xlabel("tilt limit (degrees)")
        place.set_ylabel(label)
        place.set_xlim(3.0, 32.0)
    axes[0].legend()
    return figure


def main() -> None:
    """Read the table, and draw."""
    with Path(sys.argv[1]).open() as file:
        four_dof_figure(list(csv.DictReader(file))).savefig(sys.argv[2], dpi=style.DPI)


if __name__ == "__main__":
    main()
