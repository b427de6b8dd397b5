"""The route in the YZ plane, step by step over maps of kappa (as in Fig. 6 of the paper)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.figures import style
from pipeline.figures.maps.kappa_map import KappaMap, YzWindow, kappa_map, seen_window
from pipeline.figures.maps.panels import add_kappa_bar, draw_map, map_handles, map_norm
from pipeline.figures.samples import corner_samples
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import TILT_COLUMNS
from pipeline.refine.measure import PathSamples
from pipeline.route.result import Route

MAX_PANELS = 28
_FEW = 12
"""Most panels with three to a row; with more, there are four to a row."""
_POINTS_Y, _POINTS_Z = 100, 80

_REFINED_LINE: dict[str, Any] = {"color": style.REFINED, "linewidth": 0.8, "label": "refined path"}
_ROUTE_LINE: dict[str, Any] = {"color": style.COARSE, "linewidth": 1.4, "label": "route so far"}
_START: dict[str, Any] = {
    "marker": "o",
    "color": style.GREEN,
    "markersize": 3.5,
    "linestyle": "none",
    "label": "start",
}
_GOAL: dict[str, Any] = {
    "marker": "s",
    "color": style.GREEN,
    "markersize": 6.5,
    "fillstyle": "none",
    "linestyle": "none",
    "label": "goal",
}
_HERE: dict[str, Any] = {
    "marker": "o",
    "color": style.ORANGE,
    "markeredgecolor": style.BLACK,
    "markersize": 4.0,
    "markeredgewidth": 0.6,
}


@dataclass(frozen=True, eq=False)
class _Canvas:
    """Shared by all panels; the coarse path (m, 2) reaches step i at its row `corners[i]`."""

    norm: LogNorm
    window: YzWindow
    route: Route
    coarse_yz: FloatArray
    corners: IntArray
    refined_yz: FloatArray | None


@style.styled
def route_figure(
    config: Config,
    machine: Machine,
    route: Route,
    coarse: PathSamples | None = None,
    refined: PathSamples | None = None,
) -> Figure:
    """Draw the steps of the route, at most 28, each over the map of kappa for its tilt and working mode.

    Dark is near a Type-II singularity, the yellow loops are det H = 0, the hatched area is out of reach.
    """
    steps = select_steps(route, MAX_PANELS)
    coarse_yz = (route.pose if coarse is None else coarse.pose)[:, 1:3]
    refined_yz = None if refined is None else refined.pose[:, 1:3]
    paths = [coarse_yz] if refined_yz is None else [coarse_yz, refined_yz]
    window = seen_window(
        config.route.grid, machine, route.pose[steps][:, TILT_COLUMNS], route.modes[steps], [route.pose[:, 1:3], *paths]
    )
    maps = _maps(machine, route, steps, window)
    canvas = _Canvas(
        norm=map_norm(maps, config.route.kappa_max),
        window=window,
        route=route,
        coarse_yz=coarse_yz,
        corners=np.arange(len(route)) if coarse is None else corner_samples(coarse, route),
        refined_yz=refined_yz,
    )
    return _draw(canvas, steps, maps)


def _draw(canvas: _Canvas, steps: IntArray, maps: list[KappaMap]) -> Figure:
    columns = min(3 if len(steps) <= _FEW else 4, len(steps))
    rows = -(-len(steps) // columns)
    window = canvas.window
    aspect = (window.z_largest - window.z_least) / (window.y_largest - window.y_least)
    figure = style.new_figure(style.panels_height_in(aspect, rows, columns, 0.4, 0.28, 1.25))
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    panels = list(grid.flat)
    for axes, step, a_map in zip(panels, steps, maps, strict=False):
        _draw_panel(axes, canvas, int(step), a_map)
    for axes in panels[len(steps) :]:
        axes.remove()
    style.label_yz_panels(panels[: len(steps)], columns)
    add_kappa_bar(figure, panels[: len(steps)], canvas.norm, maps[0].moment_unit, extend="max")
    figure.legend(handles=_legend_handles(canvas), loc="outside lower center", ncols=3)
    return figure


def select_steps(route: Route, count: int) -> IntArray:
    """Choose at most `count` >= 3 steps evenly, including the first, the last and that of the largest kappa."""
    last = len(route) - 1
    steps = np.unique(np.linspace(0, last, min(count, len(route))).round().astype(np.int64))
    worst = int(np.argmax(route.kappa))
    if worst not in steps:
        nearest = 1 + int(np.argmin(np.abs(steps[1:-1] - worst)))
        steps[nearest] = worst
    return steps


def _maps(machine: Machine, route: Route, steps: IntArray, window: YzWindow) -> list[KappaMap]:
    y_m = np.linspace(window.y_least, window.y_largest, _POINTS_Y)
    z_m = np.linspace(window.z_least, window.z_largest, _POINTS_Z)
    tilts = [(float(rx), float(rz)) for rx, rz in route.pose[steps][:, TILT_COLUMNS]]
    return [kappa_map(machine, y_m, z_m, tilt, int(route.modes[i])) for i, tilt in zip(steps, tilts, strict=True)]


def _draw_panel(axes: Axes, canvas: _Canvas, step: int, a_map: KappaMap) -> None:
    route = canvas.route
    draw_map(axes, a_map, canvas.norm)
    _draw_paths(axes, canvas, step)
    axes.set_xlim(canvas.window.y_least, canvas.window.y_largest)
    axes.set_ylim(canvas.window.z_least, canvas.window.z_largest)
    tilts = np.rad2deg(route.pose[step, TILT_COLUMNS])
    axes.set_title(
        f"{step}  {route.mode_names[step]}  κ {route.kappa[step]:.1f}\n"
        f"rx {_degrees(tilts[0])}  rz {_degrees(tilts[1])}",
        fontsize=style.SMALL_TEXT_PT,
        linespacing=1.1,
    )


def _degrees(angle: float) -> str:
    return f"{round(angle, 1) + 0.0:g}°".replace("-", "−")


def _draw_paths(axes: Axes, canvas: _Canvas, step: int) -> None:
    route = canvas.route
    if canvas.refined_yz is not None:
        axes.plot(*canvas.refined_yz.T, **_REFINED_LINE)
    axes.plot(*canvas.coarse_yz[: canvas.corners[step] + 1].T, **_ROUTE_LINE)
    axes.plot(*route.pose[0, 1:3], **_START)
    axes.plot(*route.pose[-1, 1:3], **_GOAL)
    axes.plot(*route.pose[step, 1:3], **_HERE)


def _legend_handles(canvas: _Canvas) -> list[Line2D | Patch]:
    handles: list[Line2D | Patch] = [Line2D([], [], **_ROUTE_LINE)]
    if canvas.refined_yz is not None:
        handles.append(Line2D([], [], **_REFINED_LINE))
    handles += [
        Line2D([], [], linestyle="none", label="this step", **_HERE),
        Line2D([], [], **_START),
        Line2D([], [], **_GOAL),
        *map_handles(),
    ]
    return handles
