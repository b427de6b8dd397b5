"""Errors by the number of poses: with those that were measured, at random, and chosen to be the most useful."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from pipeline.arrays import FloatArray
from pipeline.calibrate.predict.learning import Learning
from pipeline.figures import style

_WORST_M = 2e-3
"""Errors above are not shown: with a few poses the tracker's frame is hardly known."""


@style.styled
def learning_figure(curves: Learning) -> Figure:
    """Draw predicted errors of a reflector anywhere over the number of poses, on a logarithmic scale."""
    figure = style.new_figure(2.5)
    axes = figure.subplots()
    axes.set_yscale("log")
    total, so_far = len(curves.best_m) - 1, len(curves.measured_m) - 1
    low, high = (_shown_mm(values) for values in (curves.random_m.min(axis=0), curves.random_m.max(axis=0)))
    numbers = np.arange(total + 1)
    axes.fill_between(
        numbers, low, high, color=style.SKY_BLUE, alpha=0.4, linewidth=0.0, label="at random (a few draws)"
    )
    axes.plot(numbers, _shown_mm(curves.best_m), color=style.GREEN, label="most useful, from the start")
    axes.plot(numbers[: so_far + 1], _shown_mm(curves.measured_m), color=style.BLACK, label="measured so far")
    axes.plot(
        numbers[so_far:], _shown_mm(curves.further_m), color=style.VERMILLION, linestyle="--",
        label="and then the most useful",
    )  # fmt: skip
    axes.plot(so_far, 1e3 * curves.measured_m[-1], "o", color=style.BLACK)
    axes.annotate(
        f"{1e3 * curves.measured_m[-1]:.3f} mm", (so_far, 1e3 * curves.measured_m[-1]), (4.0, 4.0),
        textcoords="offset points", fontsize=style.SMALL_TEXT_PT,
    )  # fmt: skip
    axes.set_xlim(0.0, total)
    axes.xaxis.set_major_locator(style.count_locator())
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlabel("number of poses")
    axes.set_ylabel("predicted error of a reflector (mm)")
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def _shown_mm(values_m: FloatArray) -> FloatArray:
    return 1e3 * np.where(values_m <= _WORST_M, values_m, np.nan)
