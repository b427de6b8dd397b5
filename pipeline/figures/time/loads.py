"""Loads of a trajectory over time: jerks and forces with their limits, and the usage of every limit."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from pipeline.arrays import FloatArray
from pipeline.figures import style
from pipeline.machine.geometry import ACTUATORS, LINKS
from pipeline.retime.path_dynamics import TABLE_POINTS, dynamics_table
from pipeline.retime.quantities import JERK, QUANTITIES, Quantities, both_sides, evaluate, fractions, limited, limits
from pipeline.retime.result import Trajectory

_COLOURS = (style.BLUE, style.ORANGE, style.GREEN, style.VERMILLION, style.PURPLE, style.SKY_BLUE)
_INSTANTS = 4_001
_PANEL_IN, _REST_IN = 0.62, 0.3
"""Heights of a panel for the usage of a limit, and of what is below all of them."""
_CARTS, _TELESCOPES = slice(0, 3), slice(3, 5)


class _Panel(NamedTuple):
    """A panel: the columns of a quantity that are drawn together, its label, and the names of the columns."""

    quantity: str
    which: slice
    label: str
    names: Sequence[str]


_ROWS = (
    (
        _Panel(JERK, _CARTS, "cart jerk (m/s³)", ACTUATORS),
        _Panel(JERK, _TELESCOPES, "telescope jerk (m/s³)", ACTUATORS),
    ),
    (
        _Panel("force", _CARTS, "cart force (N)", ACTUATORS),
        _Panel("force", _TELESCOPES, "telescope force (N)", ACTUATORS),
    ),
    (_Panel("link_force", slice(0, 6), "force along links (N)", LINKS),),
)


@dataclass(frozen=True, eq=False)
class _Loads:
    """Every quantity (n, subjects) at instants t (n,), and its limits (subjects,) or (2, subjects)."""

    t_s: FloatArray
    values: dict[str, FloatArray]
    allowed: dict[str, FloatArray]


def _loads(trajectory: Trajectory, quantities: Quantities = QUANTITIES) -> _Loads:
    t = np.linspace(0.0, trajectory.duration_s, _INSTANTS)
    s, *state = (trajectory.s(t, order) for order in range(4))
    dynamics = dynamics_table(trajectory.path, TABLE_POINTS).at(s)
    values = evaluate(dynamics, *state, quantities=quantities)
    if trajectory.jerk_jumps:
        del values[JERK]
    return _Loads(t, values, limits(trajectory.path.machine, quantities))


def has_loads(trajectory: Trajectory) -> bool:
    """Check whether there is anything to draw: jerks if they are limited, forces if masses are known."""
    return not trajectory.jerk_jumps or trajectory.path.machine.masses is not None


@style.styled
def loads_figure(trajectory: Trajectory) -> Figure:
    """Draw jerks and forces of the actuators and the forces along the links over time, limits dashed.

    Carts are on the left, telescopes on the right. There are no panels of forces without masses, and none of jerks
    without limited jerk.

    Raises
    ------
    ValueError
        When there is neither.
    """
    if not has_loads(trajectory):
        raise ValueError("without masses and without limited jerk there are no loads to draw")
    loads = _loads(trajectory)
    rows = [row for row in _ROWS if row[0].quantity in loads.values]
    figure = style.new_figure(0.7 + 1.1 * len(rows))
    mosaic: list[Any] = [[row[0].label, row[-1].label] for row in rows]
    axes = figure.subplot_mosaic(mosaic, sharex=True)
    for number, panel in ((number, panel) for number, row in enumerate(rows) for panel in row):
        _draw(axes[panel.label], loads, panel)
        if number == 0 or panel.quantity == "link_force":
            style.name_lines(axes[panel.label], panel.which.stop - panel.which.start)
    for name in mosaic[-1]:
        axes[name].set_xlabel("time (s)")
        axes[name].set_xlim(0.0, loads.t_s[-1])
        axes[name].xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    for panel_axes in axes.values():
        # Panels of different widths share the axis: each needs numbers of its own.
        panel_axes.tick_params(labelbottom=True)
    for column in (0, -1):
        figure.align_ylabels([axes[row[column].label] for row in rows if column == 0 or len(row) > 1])
    limit = Line2D([], [], label="limit, where it is in sight", **style.LIMIT_LINE)
    figure.legend(handles=[limit], loc="outside lower center")
    return figure


def _draw(axes: Axes, loads: _Loads, panel: _Panel) -> None:
    """Draw a panel; a limit far above the curves would only flatten them, and is written next to the axis instead."""
    values, allowed = loads.values[panel.quantity][:, panel.which], loads.allowed[panel.quantity][..., panel.which]
    for value, colour, name in zip(values.T, _COLOURS[panel.which], panel.names[panel.which], strict=True):
        axes.plot(loads.t_s, value, color=colour, linewidth=0.7, label=name)
    used = float(np.abs(values).max())
    axes.set_ylabel(panel.label)
    far = []
    for sign, limits_of_side in zip((1.0, -1.0), both_sides(allowed), strict=True):
        for limit in np.unique(limits_of_side[np.isfinite(limits_of_side)]):
            if limit <= 2.0 * used:
                axes.axhline(sign * limit, **style.LIMIT_LINE)
            else:
                far.append(float(limit))
    if far:
        axes.set_ylabel(f"{panel.label}\nlimit {', '.join(f'{limit:g}' for limit in dict.fromkeys(far))}")
    axes.yaxis.set_major_locator(MaxNLocator(5))


@style.styled
def usage_figure(trajectory: Trajectory, quantities: Quantities = QUANTITIES) -> Figure:
    """Draw the largest fraction of each limited quantity over time, of whichever actuator or link uses most of it.

    Each has a panel of its own: together their curves would hide each other.
    """
    loads = _loads(trajectory, quantities)
    names = [name for name in limited(trajectory.path.machine, quantities) if name in loads.values]
    shown = [quantity for quantity in quantities if quantity.name in names]
    figure = style.new_figure(_PANEL_IN * len(shown) + _REST_IN)
    panels = figure.subplots(len(shown), sharex=True, sharey=True, squeeze=False)[:, 0]
    for axes, quantity, colour in zip(panels, shown, cycle((*_COLOURS, style.BLACK)), strict=False):
        share = fractions(loads.values[quantity.name], loads.allowed[quantity.name]).max(axis=1)
        axes.fill_between(loads.t_s, share, color=colour, alpha=0.25, linewidth=0.0)
        axes.plot(loads.t_s, share, color=colour, linewidth=0.7, label=quantity.words)
        axes.axhline(1.0, **style.LIMIT_LINE)
        axes.set_title(f"{quantity.words}, at most {share.max():.2f}", loc="left", fontsize=style.SMALL_TEXT_PT)
        axes.set_yticks([0.0, 0.5, 1.0])
    panels[-1].set_xlim(0.0, loads.t_s[-1])
    panels[-1].set_ylim(0.0, 1.12)
    panels[-1].set_xlabel("time (s)")
    figure.supylabel("largest part of the limit", fontsize=style.TEXT_PT)
    return figure
