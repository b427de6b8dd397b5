"""A simulated motion over time: errors as in Fig. 8 of the paper, following errors, and forces against the plan's."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from pipeline.arrays import FloatArray
from pipeline.figures import style
from pipeline.figures.time.measured import Drawn, motion_figure
from pipeline.machine.geometry import ACTUATORS, LINKS
from pipeline.simulate import Simulation
from pipeline.simulate.rows import comparison, mode_times

_ACTUATOR_COLOURS = (style.BLUE, style.ORANGE, style.GREEN, style.VERMILLION, style.PURPLE)
_IN_SIGHT = 2.0
"""A limit farther away than this many times the values is not drawn: it would flatten them."""


@style.styled
def errors_figure(simulation: Simulation) -> Figure:
    """Draw x, y, z, rx, rz over time, commanded and simulated, and their difference; lines are mode changes."""
    return motion_figure(comparison(simulation), Drawn("simulated", tuple(_changes(simulation))))


@style.styled
def following_figure(simulation: Simulation) -> Figure:
    """Draw the following errors over time, of carts above and of telescopes below; lines are mode changes."""
    figure = style.new_figure(2.8)
    panels = figure.subplots(2, 1, sharex=True)
    for axes, drives, name in zip(panels, ((0, 1, 2), (3, 4)), ("carts", "telescopes"), strict=True):
        for k in drives:
            error_mm = 1e3 * simulation.following_error_m[:, k]
            axes.plot(simulation.t_s, error_mm, color=_ACTUATOR_COLOURS[k], linewidth=0.6, label=ACTUATORS[k])
        trips = 1e3 * np.unique(simulation.drives.trip_m[list(drives)])
        axes.set_ylabel(f"{name} (mm)")
        axes.set_title(f"drives trip at {', '.join(f'{trip:g}' for trip in trips)} mm", loc="right")
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, handlelength=1.0, borderaxespad=0.0)
    _finish(panels, simulation)
    figure.align_ylabels(panels)
    figure.legend(handles=[style.change_handle()], loc="outside lower center")
    return figure


@style.styled
def forces_figure(simulation: Simulation) -> Figure:
    """Draw the forces of the drives and along the links, planned and simulated; lines are mode changes.

    Limits are drawn where they are in sight.
    """
    figure = style.new_figure(5.6)
    sides = (
        ("drives", ACTUATORS, simulation.motion.drive_n, simulation.drive_n, simulation.drives.saturation_n),
        (
            "along links",
            LINKS,
            simulation.motion.link_n,
            simulation.link_n,
            simulation.machine.force_limits_n[:, 5:],
        ),
    )
    halves: Any = figure.subfigures(1, 2)
    for half, (title, names, planned, real, limits) in zip(halves, sides, strict=True):
        column = half.subplots(len(names), 1, sharex=True)
        for k, (axes, name) in enumerate(zip(column, names, strict=True)):
            axes.plot(simulation.t_s, real[:, k], color=style.REFINED, linewidth=0.6)
            axes.plot(simulation.t_s, planned[: len(simulation), k], color=style.COARSE, linewidth=0.6)
            _draw_limits(axes, limits[:, k], float(np.abs(real[:, k]).max()))
            axes.set_ylabel(f"{name} (N)")
        column[0].set_title(title)
        half.align_ylabels(column)
        _finish(column, simulation)
    handles = [
        Line2D([], [], color=style.COARSE, label="planned"),
        Line2D([], [], color=style.REFINED, label="simulated"),
        Line2D([], [], label="limit, where it is in sight", **style.LIMIT_LINE),
        style.change_handle(),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


def _draw_limits(axes: Axes, limits: FloatArray, largest: float) -> None:
    for limit, sign in zip(limits, (1.0, -1.0), strict=True):
        if limit <= _IN_SIGHT * largest:
            axes.axhline(sign * limit, **style.LIMIT_LINE)


def _changes(simulation: Simulation) -> list[float]:
    """Times at which the simulated machine changes its working mode."""
    times = mode_times(simulation.plant.machine, simulation.pose, simulation.q_m, simulation.t_s)
    return [t for _, t in times[1:]]


def _finish(panels: Sequence[Axes], simulation: Simulation) -> None:
    """Mark mode changes and label a column of panels."""
    for axes in panels:
        style.mark_changes(axes, _changes(simulation))
        axes.yaxis.set_major_locator(MaxNLocator(4))
        axes.set_xlim(0.0, float(simulation.motion.t_s[-1]))
        axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    panels[-1].set_xlabel("time (s)")
