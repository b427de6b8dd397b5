"""The picture of the study of the machine's dimensions: `python -m tests.benchmarks.design STUDY.csv PICTURE`."""

import csv
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pipeline.figures import style
from pipeline.study.report.pareto import undominated

RATIO, KAPPA = "workspace.volume_ratio", "path.kappa_max"
RATIO_LABEL = "workspace per installation space"


@style.styled
def design_figure(rows: list[dict[str, str]]) -> Figure:
    """Draw both objectives against each other, and the best workspace run by run; the first run is the reference."""
    figure = Figure(figsize=(2 * style.WIDTH_IN, 0.7 * style.WIDTH_IN), layout="constrained")
    left, right = figure.subplots(1, 2)
    counting = [row for row in rows if not row["reason"]]
    numbers = [int(row["number"]) for row in counting]
    ratios, kappas = (np.array([float(row[name]) for row in counting]) for name in (RATIO, KAPPA))
    best = np.flatnonzero(undominated(np.column_stack([-ratios, kappas])))
    best = best[np.argsort(ratios[best])]
    left.plot(ratios, kappas, "o", color=style.GREY, label="certified designs")
    left.plot(ratios[best], kappas[best], "o-", color=style.VERMILLION, label="Pareto front")
    left.plot(ratios[:1], kappas[:1], "s", color=style.BLUE, label="reference machine")
    left.set_xlabel(RATIO_LABEL)
    left.set_ylabel("largest kappa")
    left.legend()
    right.plot(numbers, ratios, "o", color=style.GREY)
    right.step(numbers, np.maximum.accumulate(ratios), where="post", color=style.VERMILLION)
    failed = [int(row["number"]) for row in rows if row["reason"]]
    right.plot(failed, [0.03] * len(failed), "x", color=style.BLACK, transform=right.get_xaxis_transform())
    right.set_xlabel("run")
    right.set_ylabel(RATIO_LABEL)
    return figure


def main() -> None:
    """Read the table, and draw."""
    with Path(sys.argv[1]).open() as file:
        design_figure(list(csv.DictReader(file))).savefig(sys.argv[2], dpi=style.DPI)


if __name__ == "__main__":
    main()
