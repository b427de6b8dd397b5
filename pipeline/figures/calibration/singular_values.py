"""Singular values of a calibration: which directions of the parameters the data tell, and which nothing tells."""

import numpy as np
from matplotlib.figure import Figure

from pipeline.calibrate import Calibration, Verdict
from pipeline.figures import style

_ROOM = 5.0
"""Room around the values, as a factor."""


@style.styled
def singular_values_figure(calibration: Calibration, verdict: Verdict) -> Figure:
    """Draw the singular values of the Jacobian, in units of noise and of what is known, the largest first.

    Above 1 the data say more about a direction than was known. The last ones are the gauges, which change nothing that
    is seen; they are zero but for rounding, and only counted.
    """
    figure = style.new_figure(2.2)
    axes = figure.subplots()
    values = np.linalg.svd(calibration.identification.jacobian, compute_uv=False)
    values = np.pad(values, (0, max(verdict.directions - len(values), 0)))
    numbers = np.arange(1, len(values) + 1)
    seen, told = max(verdict.rank, 1), verdict.from_data
    low, high = values[:seen].min() / _ROOM, values.max() * _ROOM
    axes.set_yscale("log")
    axes.plot(numbers[:told], values[:told], "o", color=style.BLUE, label=f"from the data: {told}")
    if seen > told:
        axes.plot(
            numbers[told:seen], values[told:seen], "o", color=style.ORANGE, markerfacecolor="white",
            label=f"from the prior: {seen - told}",
        )  # fmt: skip
    unseen = verdict.directions - seen
    label = f"gauges: {verdict.gauges}"
    if unseen > verdict.gauges:
        label += f", not determined: {unseen - verdict.gauges}"
    axes.axvspan(seen + 0.5, verdict.directions + 0.5, color=style.LIGHT_GREY, linewidth=0.0, label=label)
    axes.axhline(1.0, **style.LIMIT_LINE)
    axes.annotate(
        "as much as was known", (1.0, 1.0), (0.0, -7.0), textcoords="offset points", fontsize=style.SMALL_TEXT_PT
    )
    axes.set_ylim(min(low, 1.0 / _ROOM), high)
    axes.set_xlim(0.0, verdict.directions + 0.5)
    axes.xaxis.set_major_locator(style.count_locator())
    axes.set_xlabel("direction of the parameters")
    axes.set_ylabel("singular value")
    figure.legend(loc="outside lower center", ncols=3)
    return figure
