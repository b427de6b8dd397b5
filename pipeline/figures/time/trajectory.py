"""The trajectory over time: pose and actuators, with the limits of position, velocity and acceleration."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from pipeline.arrays import FloatArray
from pipeline.figures import style
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.retime.result import TrajectorySamples

_AXIS_COLOURS = (style.BLUE, style.ORANGE, style.GREEN)
_ACTUATOR_COLOURS = (style.BLUE, style.ORANGE, style.GREEN, style.VERMILLION, style.PURPLE)
_GROUPS = ((0, 1, 2), (3, 4))
"""Carts and telescopes: their limits differ too much for one panel."""


@style.styled
def trajectory_figure(machine: Machine, samples: TrajectorySamples) -> Figure:
    """Draw the pose, and position, velocity and acceleration of the actuators over time, limits dashed.

    Carts are on the left, telescopes on the right.
    """
    figure = style.new_figure(5.0)
    panels = figure.subplots(4, 2, sharex=True)
    _draw_pose(panels[0], samples)
    speed, acceleration = machine.velocity_mps, machine.acceleration_mps2
    rows = (
        (samples.q_m, machine.actuator_limits_m, ("cart (m)", "telescope (m)")),
        (samples.qd_mps, np.column_stack([-speed, speed]), ("velocity (m/s)",) * 2),
        (samples.qdd_mps2, np.column_stack([-acceleration, acceleration]), ("acceleration (m/s²)",) * 2),
    )
    for row, (values, limits, labels) in zip(panels[1:], rows, strict=True):
        for axes, group, label in zip(row, _GROUPS, labels, strict=True):
            _draw_actuators(axes, samples.t_s, values, limits, group)
            axes.set_ylabel(label)
    for axes, group in zip(panels[1], _GROUPS, strict=True):
        style.name_lines(axes, len(group))
    for axes in panels[-1]:
        axes.set_xlabel("time (s)")
        axes.set_xlim(samples.t_s[0], samples.t_s[-1])
        axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    for column in panels.T:
        figure.align_ylabels(column)
    limit = Line2D([], [], label="limit", **style.LIMIT_LINE)
    figure.legend(handles=[limit], loc="outside lower center")
    return figure


def _draw_pose(panels: list[Axes], samples: TrajectorySamples) -> None:
    _draw_axes(panels[0], samples.t_s, samples.pose[:, :3], ("x", "y", "z"))
    panels[0].set_ylabel("position (m)")
    _draw_axes(panels[1], samples.t_s, np.rad2deg(samples.pose[:, 3:]), ("rx", "ry", "rz"))
    panels[1].set_ylabel("angle (deg)")
    panels[1].yaxis.set_major_locator(style.angle_locator())


def _draw_axes(axes: Axes, t_s: FloatArray, values: FloatArray, names: tuple[str, str, str]) -> None:
    for value, colour, name in zip(values.T, _AXIS_COLOURS, names, strict=True):
        axes.plot(t_s, value, color=colour, linewidth=0.8, label=name)
    style.name_lines(axes, len(names))


def _draw_actuators(
    axes: Axes, t_s: FloatArray, values: FloatArray, limits: FloatArray, group: tuple[int, ...]
) -> None:
    """Draw a group of actuators and their limits; limits they do not share have the actuator's colour."""
    for k in group:
        axes.plot(t_s, values[:, k], color=_ACTUATOR_COLOURS[k], linewidth=0.8, label=ACTUATORS[k])
    for bounds in limits[list(group)].T:
        shared = bool(np.all(bounds == bounds[0]))
        for k, bound in zip(group[:1] if shared else group, bounds, strict=False):
            axes.axhline(bound, **{**style.LIMIT_LINE, **({} if shared else {"color": _ACTUATOR_COLOURS[k]})})
