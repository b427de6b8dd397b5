"""How an optimisation went: its objectives over the trials, and the best value so far."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.figures import style
from pipeline.study.report.plots import Plot, stacked, suffix
from pipeline.study.table import Table


def history(table: Table, objectives: Sequence[str]) -> Plot | None:
    """Draw every objective over the number of the run, with the best value so far; None without a run that counts."""
    counting = [k for k, reason in enumerate(table.columns["reason"]) if reason is None]
    if not counting:
        return None
    names = [name.removeprefix("-") for name in objectives]
    traces: list[dict[str, Any]] = []
    for place, name in enumerate(objectives):
        numbers = [table.columns["number"][k] for k in counting]
        values = np.array([table.columns[names[place]][k] for k in counting], dtype=float)
        best = np.fmax.accumulate(values) if name.startswith("-") else np.fmin.accumulate(values)
        axes = {"x": numbers, "xaxis": "x", "yaxis": f"y{suffix(place)}", "showlegend": place == 0}
        marker = {"color": style.BLUE, "size": 7, "opacity": 0.7}
        traces.append({**axes, "mode": "markers", "name": "runs that count", "y": values.tolist(), "marker": marker})
        line = {"color": style.VERMILLION, "shape": "hv", "width": 2}
        traces.append({**axes, "mode": "lines", "name": "best so far", "y": best.tolist(), "line": line})
    layout = stacked(names, "run", grouped=False)
    about = "Of each objective by itself; the Pareto front weighs them together."
    data = [{"type": "scatter", **trace} for trace in traces]
    return Plot("Best values, run by run", about if len(names) > 1 else "", {"data": data, "layout": layout})
