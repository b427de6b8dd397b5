"""What a trajectory asks of the machine over time: jerks and forces with their limits, and the use of every limit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from pipeline.compare.figures import style
from pipeline.machine.geometry import ACTUATORS, LINKS, FloatArray
from pipeline.retime.limits import JERK, KINDS, limited, limits
from pipeline.retime.result import Trajectory
from pipeline.retime.terms import grid, terms_table

_COLOURS = (style.BLUE, style.ORANGE, style.GREEN, style.VERMILLION, style.PURPLE, style.SKY_BLUE)
_INSTANTS = 4_001
_TABLE_POINTS = 2_001
_PANEL_IN, _REST_IN = 0.62, 0.3
"""Heights of a panel for the use of a limit, and of what is below all of them."""
_CARTS, _TELESCOPES = slice(0, 3), slice(3, 5)


@dataclass(frozen=True, eq=False)
class _Loads:
    """Every quantity (n, subjects) at instants t (n,), and its limits."""

    t_s: FloatArray
    values: dict[str, FloatArray]
    allowed: dict[str, FloatArray]


def _loads(trajectory: Trajectory) -> _Loads:
    t = np.linspace(0.0, trajectory.duration_s, _INSTANTS)
    s, *state = (trajectory.s(t, order) for order in range(4))
    values = terms_table(trajectory.path, grid(_TABLE_POINTS)).at(s).values(*state)
    if trajectory.jerk_jumps:
        del values[JERK]
    return _Loads(t, values, limits(trajectory.path.machine))


@style.styled
def loads_figure(trajectory: Trajectory) -> Figure:
    """Draw jerks and forces of the actuators and the forces along the links over time, limits dashed.

    Carts are on the left, telescopes on the right. Without masses there are no forces, without limited jerk no jerks:
    their panels say so.
    """
    loads = _loads(trajectory)
    figure = style.new_figure(4.0)
    axes = figure.subplot_mosaic([["jerk c", "jerk t"], ["force c", "force t"], ["links", "links"]], sharex=True)
    for name, kind, which, label in (
        ("jerk c", "jerk", _CARTS, "cart jerk (m/s³)"),
        ("jerk t", "jerk", _TELESCOPES, "telescope jerk (m/s³)"),
        ("force c", "force", _CARTS, "cart force (N)"),
        ("force t", "force", _TELESCOPES, "telescope force (N)"),
    ):
        _draw(axes[name], loads, kind, which, ACTUATORS)
        axes[name].set_ylabel(label)
    _draw(axes["links"], loads, "link_force", slice(0, 6), LINKS)
    axes["links"].set_ylabel("force along links (N)")
    for name in ("jerk c", "jerk t", "links"):
        count = len(axes[name].get_legend_handles_labels()[0])
        if count:
            style.name_lines(axes[name], count)
    for panel in axes.values():
        # Panels of different widths share the axis: each needs numbers of its own.
        panel.tick_params(labelbottom=True)
    axes["links"].set_xlabel("time (s)")
    axes["links"].set_xlim(0.0, loads.t_s[-1])
    figure.align_ylabels([axes["jerk c"], axes["force c"], axes["links"]])
    limit = Line2D([], [], label="limit, where it is in sight", **style.LIMIT_LINE)
    figure.legend(handles=[limit], loc="outside lower center")
    return figure


def _draw(axes: Axes, loads: _Loads, kind: str, which: slice, names: Sequence[str]) -> None:
    """Draw some of a kind; limits far beyond all that is used would only flatten the curves, and are told instead."""
    if kind not in loads.values:
        axes.text(0.5, 0.5, "not limited" if kind == JERK else "no masses given", transform=axes.transAxes, ha="center")
        return
    values, allowed = loads.values[kind][:, which], loads.allowed[kind][which]
    for value, colour, name in zip(values.T, _COLOURS[which], names[which], strict=False):
        axes.plot(loads.t_s, value, color=colour, linewidth=0.7, label=name)
    used = float(np.abs(values).max())
    for limit in np.unique(allowed[np.isfinite(allowed)]):
        if limit <= 2.0 * used:
            for bound in (-limit, limit):
                axes.axhline(bound, **style.LIMIT_LINE)
        else:
            axes.set_title(f"limit {limit:g}", loc="right", fontsize=style.SMALL_TEXT_PT, color=style.GREY)
    axes.yaxis.set_major_locator(MaxNLocator(5))


@style.styled
def usage_figure(trajectory: Trajectory) -> Figure:
    """Draw which part of each kind of limit is used over time, by whichever actuator or link uses most of it.

    A panel for each kind: together their curves would hide each other.
    """
    loads = _loads(trajectory)
    names = [name for name in limited(trajectory.path.machine) if name in loads.values]
    kinds = [kind for kind in KINDS if kind.name in names]
    figure = style.new_figure(_PANEL_IN * len(kinds) + _REST_IN)
    panels = figure.subplots(len(kinds), sharex=True, sharey=True, squeeze=False)[:, 0]
    for axes, kind, colour in zip(panels, kinds, (*_COLOURS, style.BLACK), strict=False):
        share = (np.abs(loads.values[kind.name]) / loads.allowed[kind.name]).max(axis=1)
        axes.fill_between(loads.t_s, share, color=colour, alpha=0.25, linewidth=0.0)
        axes.plot(loads.t_s, share, color=colour, linewidth=0.7, label=kind.words)
        axes.axhline(1.0, **style.LIMIT_LINE)
        axes.set_title(f"{kind.words}, at most {share.max():.2f}", loc="left", fontsize=style.SMALL_TEXT_PT)
        axes.set_yticks([0.0, 0.5, 1.0])
    panels[-1].set_xlim(0.0, loads.t_s[-1])
    panels[-1].set_ylim(0.0, 1.12)
    panels[-1].set_xlabel("time (s)")
    figure.supylabel("largest part of the limit", fontsize=style.TEXT_PT)
    return figure
