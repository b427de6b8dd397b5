"""The machine in 3-D at every step of the route, small and side by side (as in Fig. 5 of the paper).

All machines are drawn in one plane by a parallel projection, in one set of axes: that costs a fraction of as many 3-D
axes, and leaves no room unused.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.spatial import ConvexHull, QhullError

from pipeline.compare.figures import style
from pipeline.compare.figures.route import select_steps
from pipeline.machine.geometry import (
    ARM_OF_LINK,
    MODE_SIGNS,
    TELESCOPES,
    FloatArray,
    IntArray,
    Machine,
    cart_joints,
    platform_arms,
)
from pipeline.route.result import Route

MAX_MACHINES = 30
_AZIMUTH, _ELEVATION = np.deg2rad([-58.0, 20.0])
_MARGIN_M = 0.16
_TITLE_M = 0.34
_AXIS_M = 0.5
_COLOURS = {-1.0: style.BLUE, 1.0: style.ORANGE}
_FIXED = np.setdiff1d(np.arange(6), TELESCOPES)
_TELESCOPE: dict[str, Any] = {"linestyle": (0, (2.2, 0.9)), "linewidth": 0.9}
_LINK: dict[str, Any] = {"linewidth": 0.9}
_PLATFORM: dict[str, Any] = {"facecolor": style.LIGHT_GREY, "edgecolor": style.BLACK, "linewidth": 0.5}


@style.styled
def machine_figure(machine: Machine, route: Route) -> Figure:
    """Draw rails, carts, links and platform at every step of the route, seen from the front, right and above.

    Arms have the colour of their working mode, dashed links are telescopes; routes of more than 30 steps are thinned.
    The dot is the TCP, its line the way it has come.
    """
    steps = select_steps(route, MAX_MACHINES)
    low, high = _window(machine, route, steps)
    columns = min(5 if len(steps) > 12 else 4, len(steps))
    rows = -(-len(steps) // columns)
    size = high - low + np.array([0.0, _TITLE_M])
    scale = (style.WIDTH_IN - 0.06) / (columns * size[0])
    figure = style.new_figure(float(rows * size[1] * scale + 0.45))
    axes = figure.subplots()
    axes.set_axis_off()
    for number, step in enumerate(steps):
        row, column = divmod(number, columns)
        origin = np.array([column, -row]) * size - low
        _draw_machine(axes, machine, route, int(step), origin)
        axes.text(
            origin[0] + low[0] + size[0] / 2.0,
            origin[1] + high[1],
            f"{step}  {route.mode_names[step]}",
            fontsize=style.SMALL_TEXT_PT,
            ha="center",
            va="bottom",
        )
    _draw_triad(axes, project(_triad_place(machine, route)) - low)
    axes.set_xlim(0.0, columns * size[0])
    axes.set_ylim(-(rows - 1) * size[1], size[1])
    axes.set_aspect("equal")
    figure.legend(handles=_legend_handles(), loc="outside lower center", ncols=4)
    return figure


def project(points: FloatArray) -> FloatArray:
    """Project points (..., 3) along the line of sight, to the right and upwards, in metres. Shape (..., 2)."""
    right = np.array([-np.sin(_AZIMUTH), np.cos(_AZIMUTH), 0.0])
    up = np.array(
        [
            -np.sin(_ELEVATION) * np.cos(_AZIMUTH),
            -np.sin(_ELEVATION) * np.sin(_AZIMUTH),
            np.cos(_ELEVATION),
        ]
    )
    return np.stack([points @ right, points @ up], axis=-1)


def _joints(machine: Machine, route: Route, steps: IntArray) -> tuple[FloatArray, FloatArray]:
    """Cart and platform joints C_l, A_l at steps (n,), each (n, 6, 3)."""
    pose = route.pose[steps]
    return cart_joints(machine, route.q_m[steps, :3]), pose[:, None, :3] + platform_arms(machine, pose)


def _rails(machine: Machine) -> FloatArray:
    """Both ends of each rail, (3, 2, 3)."""
    return np.stack(
        [np.column_stack([machine.travel_m[:, end], machine.rails_m]) for end in (0, 1)],
        axis=1,
    )


def _window(machine: Machine, route: Route, steps: IntArray) -> tuple[FloatArray, FloatArray]:
    """Least and largest projected coordinates of all there is to draw, each (2,)."""
    parts = [*_joints(machine, route, steps), _rails(machine), route.pose[:, :3]]
    seen = np.concatenate([project(part).reshape(-1, 2) for part in parts])
    return seen.min(axis=0) - _MARGIN_M / 2.0, seen.max(axis=0) + _MARGIN_M / 2.0


def _draw_machine(axes: Axes, machine: Machine, route: Route, step: int, origin: FloatArray) -> None:
    carts, platform = (joints[0] for joints in _joints(machine, route, np.array([step])))
    colours = [_COLOURS[sign] for sign in MODE_SIGNS[route.modes[step]]]
    links = project(np.stack([carts, platform], axis=1)) + origin
    of_link = [colours[arm] for arm in ARM_OF_LINK]
    rails = project(_rails(machine)) + origin
    axes.add_collection(LineCollection(list(rails), colors=style.GREY, linewidths=1.2, zorder=1.0))
    tcp = project(route.pose[: step + 1, :3]) + origin
    outline = _hull(np.vstack([links[:, 1], tcp[-1:]]))
    axes.add_collection(PolyCollection([outline], zorder=2.0, **_PLATFORM))
    for which, look in ((_FIXED, _LINK), (TELESCOPES, _TELESCOPE)):
        lines = LineCollection([links[k] for k in which], colors=[of_link[k] for k in which], zorder=3.0, **look)
        axes.add_collection(lines)
    feet = project(np.column_stack([route.q_m[step, :3], machine.rails_m])) + origin
    beams = np.stack([feet[ARM_OF_LINK], links[:, 0]], axis=1)
    axes.add_collection(LineCollection(list(beams), colors=style.BLACK, linewidths=0.9, zorder=3.5))
    for foot, colour in zip(feet, colours, strict=True):
        axes.plot(
            *foot, "s", color=colour, markersize=2.6, markeredgecolor=style.BLACK, markeredgewidth=0.4, zorder=4.0
        )
    axes.plot(*tcp.T, color=style.VERMILLION, linewidth=0.6, zorder=4.0)
    axes.plot(*tcp[-1], "o", color=style.VERMILLION, markersize=1.8, zorder=5.0)


def _hull(points: FloatArray) -> FloatArray:
    """Corners of the least convex outline of points (n, 2); the points themselves where they are on one line."""
    try:
        corners: FloatArray = points[ConvexHull(points).vertices]
    except QhullError:
        return points
    return corners


def _triad_place(machine: Machine, route: Route) -> FloatArray:
    """Choose a place for the axes beside the first machine: above rail 3, where its arm is not. Shape (3,)."""
    least, largest = machine.travel_m[2]
    part = 0.8 if MODE_SIGNS[route.modes[0]][2] < 0.0 else 0.0
    y, z = machine.rails_m[2]
    height = machine.rails_m[:, 1].max() - z
    return np.array([least + part * (largest - least), y, z + 0.15 * height])


def _draw_triad(axes: Axes, place: FloatArray) -> None:
    """Draw half a metre along each axis from a place (2,) of the drawing."""
    for direction, name in zip(np.eye(3), "xyz", strict=True):
        tip = place + _AXIS_M * project(direction)
        axes.annotate(
            "",
            xy=tuple(tip),
            xytext=tuple(place),
            arrowprops={"arrowstyle": "-|>", "linewidth": 0.6, "mutation_scale": 4.0, "shrinkA": 0.0, "shrinkB": 0.0},
        )
        axes.annotate(
            name,
            xy=tuple(tip),
            xytext=tuple(3.0 * project(direction)),
            textcoords="offset points",
            fontsize=style.SMALL_TEXT_PT - 1,
            ha="center",
            va="center",
        )


def _legend_handles() -> list[Line2D | Patch]:
    return [
        Line2D([], [], color=_COLOURS[-1.0], label="arm left (L)", **_LINK),
        Line2D([], [], color=_COLOURS[1.0], label="arm right (R)", **_LINK),
        Line2D([], [], color=style.BLACK, label="telescope", **_TELESCOPE),
        Patch(label="platform", **_PLATFORM),
        Line2D([], [], color=style.GREY, linewidth=1.2, label="rail"),
        Line2D([], [], color=style.VERMILLION, linewidth=0.6, label="way of the TCP"),
        Line2D([], [], marker="$\\rightarrow$", linestyle="none", color=style.BLACK, label="axes, 0.5 m long"),
    ]
