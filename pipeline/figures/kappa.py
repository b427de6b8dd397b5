"""kappa along the coarse and the refined path, and the working modes along them."""

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.figures import style
from pipeline.figures.samples import corner_samples
from pipeline.machine.statics import moment_unit
from pipeline.machine.working_modes import working_modes
from pipeline.refine.measure import PathSamples
from pipeline.route.metric import arc_length, step_sizes
from pipeline.route.result import Route

_MODE_COLOURS = {-1.0: style.SKY_BLUE, 1.0: style.ORANGE}
_MODE_LETTERS = {-1.0: "L", 1.0: "R"}
_LEAST_LABELLED = 0.04
"""Shortest stretch that is labelled, as a fraction of the axis."""


@style.styled
def kappa_figure(config: Config, route: Route, coarse: PathSamples, refined: PathSamples) -> Figure:
    """Draw kappa over the path length, in the route's metric, and above it the working mode of each arm.

    The area under a curve is the integral that the refinement minimises; the legend states it.
    """
    steps = step_sizes(config.route)
    lengths = arc_length(coarse.pose, steps), arc_length(refined.pose, steps)
    figure = style.new_figure(3.5)
    strips, axes = figure.subplots(2, 1, sharex=True, height_ratios=[0.32, 1.0])
    _draw_modes(strips, [working_modes(coarse.reach_m), working_modes(refined.reach_m)], lengths)
    handles = _draw_kappa(axes, lengths, (coarse.kappa, refined.kappa))
    axes.set_ylabel(f"κ ({moment_unit(refined.machine)})")
    corners = corner_samples(coarse, route)
    handles += axes.plot(
        lengths[0][corners],
        coarse.kappa[corners],
        "o",
        color=style.COARSE,
        markersize=2.2,
        label="steps of the route",
    )
    figure.legend(handles=handles, loc="outside lower center", ncols=1)
    return figure


def _draw_kappa(
    axes: Axes, lengths: tuple[FloatArray, FloatArray], kappas: tuple[FloatArray, FloatArray]
) -> list[Line2D]:
    handles = []
    longest, top = max(length[-1] for length in lengths), max(kappa.max() for kappa in kappas)
    coarse_integral = float(np.trapezoid(kappas[0], lengths[0]))
    for row, (name, colour, length, kappa) in enumerate(
        zip(("coarse path", "refined path"), (style.COARSE, style.REFINED), lengths, kappas, strict=True)
    ):
        integral = float(np.trapezoid(kappa, length))
        change = f" ({100.0 * (integral / coarse_integral - 1.0):+.1f} %)" if row else ""
        label = f"{name}: integral {integral:.1f}{change}, largest {kappa.max():.2f}"
        handles += axes.plot(length, kappa, color=colour, label=label.replace("-", "−"))
        _label_maximum(axes, length, kappa, colour, (longest, top * (1.28 - 0.12 * row)))
    axes.set_xlim(0.0, longest)
    axes.set_ylim(0.0, 1.36 * top)
    axes.set_xlabel(style.LENGTH_LABEL)
    return handles


def _label_maximum(axes: Axes, length: FloatArray, kappa: FloatArray, colour: str, place: tuple[float, float]) -> None:
    """Write the largest kappa above both curves, each path at its own height, with a line to its place."""
    longest, height = place
    worst = int(np.argmax(kappa))
    axes.annotate(
        f"{kappa[worst]:.1f}",
        xy=(length[worst], kappa[worst]),
        xytext=(float(np.clip(length[worst], 0.06 * longest, 0.94 * longest)), height),
        color=colour,
        fontsize=style.SMALL_TEXT_PT,
        ha="center",
        va="center",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
        arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.5, "shrinkA": 0.0, "shrinkB": 0.0},
    )


def _draw_modes(axes: Axes, modes: list[FloatArray], lengths: tuple[FloatArray, FloatArray]) -> None:
    """Draw a strip per path and arm, whose colour and letter are the working mode."""
    axes.grid(False)
    axes.set_title("working mode of each arm", loc="left", fontsize=style.SMALL_TEXT_PT)
    ticks = {}
    for path, (signs, length) in enumerate(zip(modes, lengths, strict=True)):
        for arm in range(3):
            y = 3.6 * path + arm
            ticks[y] = f"{('coarse', 'refined')[path]}, arm {arm + 1}"
            _draw_strip(axes, y, signs[:, arm], length, max(lengths[0][-1], lengths[1][-1]))
    axes.set_yticks(list(ticks), list(ticks.values()))
    axes.set_ylim(6.2, -0.6)
    axes.tick_params(left=False, bottom=False, labelbottom=False)
    axes.spines[:].set_visible(False)


def _draw_strip(axes: Axes, y: float, signs: FloatArray, length: FloatArray, longest: float) -> None:
    """Draw one arm's stretches of constant mode."""
    changes = np.flatnonzero(np.diff(signs)) + 1
    bounds = [0, *changes.tolist(), len(signs) - 1]
    for begin, end in pairwise(bounds):
        sign, left, right = float(signs[begin]), length[begin], length[end]
        axes.barh(y, right - left, left=left, height=0.9, color=_MODE_COLOURS[sign], linewidth=0.0)
        if right - left >= _LEAST_LABELLED * longest:
            axes.text(
                0.5 * (left + right),
                y,
                _MODE_LETTERS[sign],
                fontsize=style.SMALL_TEXT_PT - 1,
                ha="center",
                va="center_baseline",
            )
