"""The commanded pose over time, with the steps of the route (as in Fig. 8 of the paper)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.figures import style
from pipeline.figures.samples import corner_samples
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import TILT_COLUMNS
from pipeline.machine.working_modes import mode_names, reach_along_rails, working_modes
from pipeline.refine.measure import PathSamples
from pipeline.retime.result import TrajectorySamples
from pipeline.route.metric import arc_length, step_sizes
from pipeline.route.result import Route

_COLOURS = {
    "x": style.BLUE,
    "y": style.ORANGE,
    "z": style.GREEN,
    "rx": style.VERMILLION,
    "rz": style.PURPLE,
}
_LEAST_APART = 0.07
"""Fraction of the axis that the names of two working modes need to be side by side."""


@style.styled
def pose_figure(
    config: Config, machine: Machine, route: Route, coarse: PathSamples, trajectory: TrajectorySamples
) -> Figure:
    """Draw x, y, z, and the controlled angles rx, rz, over time; circles are the steps of the route.

    A step is drawn at the time when the trajectory has covered the same fraction of its length as the coarse path has
    there. Vertical lines are changes of working mode, with the names above.
    """
    figure = style.new_figure(3.2)
    position, angle = figure.subplots(2, 1, sharex=True)
    times = _step_times(config, route, coarse, trajectory)
    angles, route_angles = np.rad2deg(trajectory.pose[:, TILT_COLUMNS]), np.rad2deg(route.pose[:, TILT_COLUMNS])
    _draw(position, trajectory.t_s, trajectory.pose[:, :3], times, route.pose[:, :3], ("x", "y", "z"))
    _draw(angle, trajectory.t_s, angles, times, route_angles, ("rx", "rz"))
    position.set_ylabel("position (m)")
    angle.set_ylabel("angle (deg)")
    angle.yaxis.set_major_locator(style.angle_locator())
    _mark_modes([position, angle], machine, trajectory)
    angle.set_xlabel("time (s)")
    angle.set_xlim(0.0, trajectory.duration_s)
    figure.align_ylabels([position, angle])
    curves = [*position.get_lines()[:3], *angle.get_lines()[:2]]
    figure.legend(handles=[*curves, _step_handle(), _mode_handle()], loc="outside lower center", ncols=4)
    return figure


def _draw(
    axes: Axes, t_s: FloatArray, values: FloatArray, step_t_s: FloatArray, steps: FloatArray, names: tuple[str, ...]
) -> None:
    for value, name in zip(values.T, names, strict=True):
        axes.plot(t_s, value, color=_COLOURS[name], label=name)
    for value, name in zip(steps.T, names, strict=True):
        axes.plot(step_t_s, value, "o", color=_COLOURS[name], fillstyle="none", markersize=2.4, markeredgewidth=0.5)


def _step_times(config: Config, route: Route, coarse: PathSamples, trajectory: TrajectorySamples) -> FloatArray:
    """Find when the trajectory has covered the fraction of its length that the coarse path has at each step (n,)."""
    sizes = step_sizes(config.route)
    before, gone = arc_length(coarse.pose, sizes), arc_length(trajectory.pose, sizes)
    parts = before[corner_samples(coarse, route)] / before[-1]
    return np.asarray(np.interp(parts * gone[-1], gone, trajectory.t_s))


def _mark_modes(panels: list[Axes], machine: Machine, trajectory: TrajectorySamples) -> None:
    """Draw a line where an arm changes its mode, and write every mode over the middle of its stretch."""
    modes = working_modes(reach_along_rails(machine, trajectory.pose, trajectory.q_m[:, :3]))
    changes = 1 + np.flatnonzero((np.diff(modes, axis=0) != 0.0).any(axis=1))
    bounds = trajectory.t_s[np.concatenate([[0], changes, [len(modes) - 1]])]
    for axes in panels:
        for t in bounds[1:-1]:
            axes.axvline(float(t), **style.LIMIT_LINE)
    for first, last, row in zip(bounds[:-1], bounds[1:], [0, *changes.tolist()], strict=True):
        if last - first >= _LEAST_APART * trajectory.duration_s:
            panels[0].annotate(
                mode_names(modes[row : row + 1])[0],
                xy=(float(first + last) / 2.0, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(0.0, 2.0),
                textcoords="offset points",
                ha="center",
                va="bottom",
                fontsize=style.SMALL_TEXT_PT,
            )


def _step_handle() -> Line2D:
    return Line2D([], [], marker="o", linestyle="none", color=style.BLACK, fillstyle="none", label="route step")


def _mode_handle() -> Line2D:
    return Line2D([], [], label="mode change", **style.LIMIT_LINE)
