"""Clearance and tilt along the coarse and the refined path, with their limits."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.config import Config
from pipeline.figures import style
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import TILT_COLUMNS
from pipeline.refine.measure import PathSamples
from pipeline.route.metric import arc_length, step_sizes


@style.styled
def clearance_figure(config: Config, machine: Machine, coarse: PathSamples, refined: PathSamples) -> Figure:
    """Draw the least distances between axes, and the tilts, over the path length, with dashed limits.

    Distances to rails are shown if the configuration limits them.
    """
    steps = step_sizes(config.route)
    rails = bool(np.isfinite(machine.link_rail_m))
    figure = style.new_figure(4.4 if rails else 3.6)
    panels = list(figure.subplots(4 if rails else 3, 1, sharex=True))
    for samples, colour, name in (
        (coarse, style.COARSE, "coarse path"),
        (refined, style.REFINED, "refined path"),
    ):
        length = arc_length(samples.pose, steps)
        curves = [samples.link_distance_m, *np.rad2deg(samples.pose[:, TILT_COLUMNS]).T]
        if rails:
            curves.insert(1, samples.rail_distance_m)
        for axes, curve in zip(panels, curves, strict=True):
            axes.plot(length, curve, color=colour, label=name)
    _limit_distance(panels[0], "least link-link\ndistance (m)", machine.link_link_m)
    if rails:
        _limit_distance(panels[1], "least link-rail\ndistance (m)", machine.link_rail_m)
    for axes, axis in zip(panels[-2:], ("rx", "rz"), strict=True):
        limit = config.refine.lock_tolerance_deg if axis in config.task.locked_axes else config.task.tilt_max_deg
        axes.axhline(-limit, **style.LIMIT_LINE)
        axes.axhline(limit, **style.LIMIT_LINE)
        axes.set_ylabel(f"{axis} (deg)")
        axes.yaxis.set_major_locator(style.angle_locator())
    panels[-1].set_xlabel(style.LENGTH_LABEL)
    panels[-1].set_xlim(left=0.0)
    figure.align_ylabels(panels)
    figure.legend(handles=panels[0].get_lines(), loc="outside lower center", ncols=3)
    return figure


def _limit_distance(axes: Axes, label: str, least_m: float) -> None:
    axes.axhline(least_m, **style.LIMIT_LINE, label="limit")
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel(label)
