"""The machine at start and goal, and its platform larger."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.figures import style
from pipeline.figures.machine import Stance, draw_machine, drawn_window, legend_handles, stances_at
from pipeline.figures.silhouettes import project
from pipeline.limits.bodies.obstacle_distance import obstacles_of
from pipeline.machine.bodies.meshes import body_meshes
from pipeline.machine.drawing import drawn_points
from pipeline.machine.geometry import LINKS, Machine

_PIECES = 40
"""Of long bodies, so that what is in front covers what is behind."""
_AROUND_M, _SCALE_M = 0.1, 0.1
_APART_PT = 7.0
_HALO = [withStroke(linewidth=1.5, foreground="white")]


@style.styled
def task_figure(config: Config, machine: Machine, pose: FloatArray, q_m: FloatArray, titles: Sequence[str]) -> Figure:
    """Draw machine and obstacles at poses (n, 6) with actuators (n, 5), and below each the platform, larger.

    Both are seen from the front, right and above, as in `machine_figure`. Joints of the platform have their names.
    """
    meshes = body_meshes(machine, obstacles_of(config), _PIECES)
    near = tuple(mesh for mesh in meshes if not mesh.endless)
    stances = stances_at(machine, pose, q_m, titles)
    windows = [
        np.stack([drawn_window(machine, meshes, stances, pose[:, :3])] * len(stances)),
        _around(machine, stances),
    ]
    heights = [float(np.ptp(window[0, :, 1]) / np.ptp(window[0, :, 0])) for window in windows]
    width = style.WIDTH_IN / len(stances)
    figure = style.new_figure(width * sum(heights) + 0.7)
    panels = figure.subplots(2, len(stances), squeeze=False, height_ratios=heights)
    for column, stance in enumerate(stances):
        for row, bodies in enumerate((meshes, near)):
            axes, (low, high) = panels[row, column], windows[row][column]
            draw_machine(axes, machine, bodies, stance, np.zeros(2))
            axes.set_axis_off()
            axes.set_xlim(low[0], high[0])
            axes.set_ylim(low[1], high[1])
            axes.set_aspect("equal")
        panels[0, column].set_title(stance.title)
        _name_joints(panels[1, column], machine, stance)
        _draw_scale(panels[1, column])
    rods = any(mesh.is_link for mesh in meshes)
    figure.legend(handles=legend_handles(False, rods)[:-1], loc="outside lower center", ncols=3)
    return figure


def _around(machine: Machine, stances: list[Stance]) -> FloatArray:
    """Return what of each drawing is around the platform, all of one size: least and largest coordinates, (n, 2, 2)."""
    ends = []
    for stance in stances:
        points = drawn_points(machine, stance.pose, stance.q_m)
        seen = project(np.vstack([stance.pose[:3], points.platform_joints_m]))
        ends.append([seen.min(axis=0), seen.max(axis=0)])
    low, high = np.array(ends).swapaxes(0, 1)
    middle, half = (low + high) / 2.0, (high - low).max(axis=0) / 2.0 + _AROUND_M
    return np.stack([middle - half, middle + half], axis=1)


def _draw_scale(axes: Axes) -> None:
    """Draw ten centimetres in the lower left corner."""
    left, bottom = axes.get_xlim()[0] + 0.02, axes.get_ylim()[0] + 0.02
    axes.plot([left, left + _SCALE_M], [bottom] * 2, color=style.BLACK, linewidth=1.5, zorder=6.0)
    axes.annotate(
        f"{_SCALE_M:g} m", (left, bottom), (0.0, 3.0), textcoords="offset points", fontsize=style.SMALL_TEXT_PT,
        zorder=7.0, path_effects=_HALO,
    )  # fmt: skip


def _name_joints(axes: Axes, machine: Machine, stance: Stance) -> None:
    """Write the names of joints beside them, away from their middle."""
    places = project(drawn_points(machine, stance.pose, stance.q_m).platform_joints_m)
    ways = places - places.mean(axis=0)
    ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-9)
    axes.plot(*places.T, "o", color=style.BLACK, markersize=1.5, zorder=6.0)
    for name, place, way in zip(LINKS, places, ways, strict=True):
        axes.annotate(
            name, tuple(place), tuple(_APART_PT * way), textcoords="offset points", fontsize=style.SMALL_TEXT_PT,
            ha="center", va="center", zorder=7.0, path_effects=_HALO,
        )  # fmt: skip
