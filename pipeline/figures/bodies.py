"""Distances of the nearest pairs of bodies along the refined path, with their limit."""

import numpy as np
from matplotlib.figure import Figure

from pipeline.config import Config
from pipeline.errors import ArgumentError
from pipeline.figures import style
from pipeline.limits.bodies.pairs import kept_apart, pair_distances, pair_names
from pipeline.machine.geometry import Machine
from pipeline.refine.measure import PathSamples
from pipeline.route.metric import arc_length, step_sizes

_LOOKS = tuple(
    (colour, dashes)
    for dashes in ("-", (0, (4, 1)))
    for colour in (style.BLUE, style.VERMILLION, style.GREEN, style.PURPLE)
)
"""Of the pairs that are named, the nearest first."""
_REACH_M = 0.06
"""Distances are drawn so far above their limit."""


def has_pairs(config: Config, machine: Machine, refined: PathSamples) -> bool:
    """Tell whether there are bodies to keep apart."""
    return any(bodies.pairs for bodies in kept_apart(config, machine))


@style.styled
def bodies_figure(config: Config, machine: Machine, refined: PathSamples) -> Figure:
    """Draw the distance of each pair of bodies over the length; the nearest pairs are named, with their least distance.

    Raises
    ------
    ArgumentError
        If nothing has bodies.
    """
    if not (kept := kept_apart(config, machine)):
        raise ArgumentError("config: expected machine.bodies, machine.link_bodies or task.obstacles")
    limit, names = kept[0].clearance_m, pair_names(kept)
    distances = pair_distances(kept, refined, limit + _REACH_M)
    length = arc_length(refined.pose, step_sizes(config.route))
    least = distances.min(axis=0)
    order = np.argsort(least, kind="stable").tolist()
    distances[distances >= limit + _REACH_M] = np.nan
    seen = [k for k in order if least[k] < limit + _REACH_M]
    figure = style.new_figure(2.9)
    axes = figure.subplots()
    handles = []
    for k, (colour, dashes) in zip(order, _LOOKS, strict=False):
        label = f"{names[k]} ({1e3 * least[k]:.1f} mm)"
        handles += axes.plot(length, 1e3 * distances[:, k], color=colour, linestyle=dashes, zorder=3.0, label=label)
    others = [k for k in seen if k not in order[: len(_LOOKS)]]
    if others:
        lines = axes.plot(length, 1e3 * distances[:, others], color=style.GREY, linewidth=0.3)
        lines[0].set_label(f"{len(others)} other pairs" if len(others) > 1 else "1 other pair")
        handles.append(lines[0])
    handles.append(axes.axhline(1e3 * limit, label=f"limit ({1e3 * limit:g} mm)", **style.LIMIT_LINE))
    axes.set_xlabel(style.LENGTH_LABEL)
    axes.set_ylabel("distance of bodies (mm)")
    axes.set_xlim(0.0, float(length[-1]))
    axes.set_ylim(bottom=min(0.0, 1e3 * float(least.min())), top=1e3 * (limit + _REACH_M))
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure
