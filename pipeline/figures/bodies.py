"""Distances of the nearest pairs of bodies, and of bodies and obstacles, along the refined path, with their limit."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.errors import ArgumentError
from pipeline.figures import style
from pipeline.limits.bodies.pairs import kept_apart
from pipeline.machine.bodies.distances import body_distances, least_distance
from pipeline.machine.geometry import Machine
from pipeline.machine.shapes.model import Bodies
from pipeline.refine.measure import PathSamples
from pipeline.route.metric import arc_length, step_sizes

_LOOKS = tuple(
    (colour, dashes)
    for dashes in ("-", (0, (4, 1)))
    for colour in (style.BLUE, style.VERMILLION, style.GREEN, style.PURPLE)
)
"""Of the pairs that are named, the nearest first."""
_NAMED_OBSTACLES = 4
"""Pairs with obstacles that are named: they are often far."""
_LONG_LABEL = 34
"""Letters of a label beyond which no two are beside each other."""
_REACH_M, _BEYOND = 0.06, 3.0
"""Distances are drawn so far above their limit, or to so many times the least one."""


def has_pairs(config: Config, machine: Machine, refined: PathSamples) -> bool:
    """Tell whether there are bodies to keep apart."""
    return any(bodies.pairs for bodies in kept_apart(config, machine))


@style.styled
def bodies_figure(config: Config, machine: Machine, refined: PathSamples) -> Figure:
    """Draw the distance of each pair over the length, of bodies and of what is fixed in space, each with its limit.

    The nearest pairs are named, with their least distance.

    Raises
    ------
    ArgumentError
        If nothing has bodies.
    """
    if not (kept := kept_apart(config, machine)):
        raise ArgumentError("config: expected machine.bodies, machine.link_bodies or task.obstacles")
    length = arc_length(refined.pose, step_sizes(config.route))
    figure = style.new_figure(2.9 if len(kept) == 1 else 4.6)
    shares = {"height_ratios": [3.0, 2.0][: len(kept)]}
    panels = figure.subplots(len(kept), 1, sharex=True, squeeze=False, gridspec_kw=shares)[:, 0]
    for axes, bodies in zip(panels, kept, strict=True):
        _draw_pairs(axes, bodies, refined, length)
        axes.set_ylabel("distance of bodies (mm)" if bodies is machine.bodies else "distance from\nobstacles (mm)")
    panels[0].set_xlim(0.0, float(length[-1]))
    panels[-1].set_xlabel(style.LENGTH_LABEL)
    figure.align_ylabels(panels)
    return figure


def _draw_pairs(axes: Axes, bodies: Bodies, samples: PathSamples, length: FloatArray) -> None:
    """Draw the pairs that come near, the nearest of them with their names above the panel."""
    top = max(bodies.clearance_m + _REACH_M, _BEYOND * least_distance(bodies, samples))
    distances_m = body_distances(bodies, samples, top)
    least = distances_m.min(axis=0)
    seen = [k for k in np.argsort(least, kind="stable").tolist() if least[k] < top]
    looks = _LOOKS[:_NAMED_OBSTACLES] if any(hull.is_obstacle for hull in bodies.hulls) else _LOOKS
    curves = 1e3 * np.where(distances_m < top, distances_m, np.nan)
    for k, (colour, dashes) in zip(seen, looks, strict=False):
        label = f"{bodies.names[k]} ({1e3 * least[k]:.1f} mm)"
        axes.plot(length, curves[:, k], color=colour, linestyle=dashes, zorder=3.0, label=label)
    if others := seen[len(looks) :]:
        lines = axes.plot(length, curves[:, others], color=style.GREY, linewidth=0.3)
        lines[0].set_label(f"{len(others)} other pairs" if len(others) > 1 else "1 other pair")
    limit = 1e3 * bodies.clearance_m
    axes.axhline(limit, label=f"limit ({limit:g} mm)", **style.LIMIT_LINE)
    axes.set_ylim(bottom=min(0.0, 1e3 * float(least.min())), top=1e3 * top)
    longest = max(len(str(line.get_label())) for line in axes.get_lines())
    style.name_lines(axes, 2 if longest <= _LONG_LABEL else 1)
