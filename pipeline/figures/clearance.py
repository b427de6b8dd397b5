"""Clearance and tilt along the coarse and the refined path, with their limits."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.config import Config
from pipeline.figures import style
from pipeline.limits import Curve, ShownLimit, path_limits
from pipeline.machine.geometry import Machine
from pipeline.refine.measure import PathSamples
from pipeline.route.metric import arc_length, step_sizes


@style.styled
def clearance_figure(config: Config, machine: Machine, coarse: PathSamples, refined: PathSamples) -> Figure:
    """Draw every limited quantity over the length, a panel each, with its limits dashed."""
    steps = step_sizes(config.route)
    limits = [limit for limit in path_limits(config, machine) if isinstance(limit, ShownLimit)]
    both = [[curve for limit in limits for curve in limit.curves(samples)] for samples in (coarse, refined)]
    count = len(both[0])
    figure = style.new_figure(3.6 + 0.8 * (count - 3))
    panels = list(figure.subplots(count, 1, sharex=True))
    for samples, curves, colour, name in (
        (coarse, both[0], style.COARSE, "coarse path"),
        (refined, both[1], style.REFINED, "refined path"),
    ):
        length = arc_length(samples.pose, steps)
        for axes, curve in zip(panels, curves, strict=True):
            axes.plot(length, curve.values, color=colour, label=name)
    for axes, curve in zip(panels, both[0], strict=True):
        _draw_limits(axes, curve)
    panels[-1].set_xlabel(style.LENGTH_LABEL)
    panels[-1].set_xlim(left=0.0)
    figure.align_ylabels(panels)
    figure.legend(handles=panels[0].get_lines(), loc="outside lower center", ncols=3)
    return figure


def _draw_limits(axes: Axes, curve: Curve) -> None:
    for limit in (curve.least, curve.largest):
        if np.isfinite(limit):
            axes.axhline(limit, **style.LIMIT_LINE, label="limit")
    if np.isinf(curve.largest) and curve.least >= 0.0:
        axes.set_ylim(bottom=0.0)
    if curve.unit == "deg":
        axes.yaxis.set_major_locator(style.angle_locator())
    name = "\n".join(curve.name.rsplit(" ", 1))
    axes.set_ylabel(f"{name} ({curve.unit})")
