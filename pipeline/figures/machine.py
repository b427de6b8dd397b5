"""The machine in 3-D, at every step of the route (as in Fig. 5 of the paper) or at any poses, small and side by side.

All machines are drawn by a parallel projection in one set of 2-D axes: much faster than as many 3-D axes, and without
unused space.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pipeline.arguments import require_array, require_one_length
from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.errors import ArgumentError
from pipeline.figures import style
from pipeline.figures.maps.route import select_steps
from pipeline.figures.silhouettes import project, silhouettes
from pipeline.limits.bodies.obstacle_distance import obstacles_of
from pipeline.machine.bodies.meshes import BodyMesh, body_meshes
from pipeline.machine.drawing import DrawnPoints, drawn_points, platform_bars, rail_ends
from pipeline.machine.geometry import ARM_OF_LINK, MODE_SIGNS, TELESCOPES, Machine
from pipeline.machine.shapes.model import FrameKind
from pipeline.machine.working_modes import mode_names, reach_along_rails
from pipeline.route.result import Route

MAX_MACHINES = 30
_MARGIN_M = 0.16
_TITLE_M = 0.34
_AXIS_M = 0.5
_COLOURS = {-1.0: style.BLUE, 1.0: style.ORANGE}
_FIXED = np.setdiff1d(np.arange(6), TELESCOPES)
_TELESCOPE: dict[str, Any] = {"linestyle": (0, (2.2, 0.9)), "linewidth": 0.9}
_LINK: dict[str, Any] = {"linewidth": 0.9}
_PLATFORM: dict[str, Any] = {"color": "#5F5F5F", "linewidth": 1.4}
_FLOOR = "#EEEEEE"
_PIECES = 12
"""Of long bodies, so that what is in front covers what is behind."""


@dataclass(frozen=True, eq=False)
class Stance:
    """A machine to draw: pose (6,), actuators (5,), sides of its arms (3,), title, and the path of the TCP so far."""

    pose: FloatArray
    q_m: FloatArray
    sides: FloatArray
    title: str
    way_m: FloatArray


@style.styled
def machine_figure(machine: Machine, route: Route, config: Config | None = None) -> Figure:
    """Draw rails, carts, links and platform at every step of the route, seen from the front, right and above.

    Arms have the colour of their working mode, dashed links are telescopes; at most 30 steps are drawn. The dot is the
    TCP, the line its path so far. With a configuration the obstacles of its task are drawn, too.
    """
    stances = [
        Stance(
            pose=route.pose[step],
            q_m=route.q_m[step],
            sides=MODE_SIGNS[route.modes[step]],
            title=f"{step}  {route.mode_names[step]}",
            way_m=route.pose[: step + 1, :3],
        )
        for step in select_steps(route, MAX_MACHINES)
    ]
    obstacles = None if config is None else obstacles_of(config)
    return _draw(machine, body_meshes(machine, obstacles, _PIECES), stances, route.pose[:, :3])


@style.styled
def postures_figure(machine: Machine, pose: FloatArray, q_m: FloatArray, titles: Sequence[str] | None = None) -> Figure:
    """Draw the machine at poses (n, 6) with actuators (n, 5) side by side, as `machine_figure` does for a route.

    Without titles, the title of a machine is its working mode.

    Raises
    ------
    ArgumentError
        If poses or actuators have other shapes or hold what is no finite number, or there is none.
    """
    pose, q_m = require_array("pose", pose, ("...", 6)), require_array("q_m", q_m, ("...", 5))
    pose, q_m = pose.reshape(-1, 6), q_m.reshape(-1, 5)
    require_one_length(pose=pose, q_m=q_m, titles=pose if titles is None else titles)
    if not len(pose):
        raise ArgumentError("pose: expected at least one")
    stances = stances_at(machine, pose, q_m, titles)
    return _draw(machine, body_meshes(machine, pieces=_PIECES), stances, pose[:, :3])


def stances_at(machine: Machine, pose: FloatArray, q_m: FloatArray, titles: Sequence[str] | None) -> list[Stance]:
    """Collect what is drawn at poses (n, 6) with actuators (n, 5); without titles these are the working modes."""
    sides = np.where(reach_along_rails(machine, pose, q_m[:, :3]) < 0.0, -1.0, 1.0)
    names = mode_names(sides) if titles is None else titles
    return [
        Stance(pose=a_pose, q_m=q, sides=side, title=name, way_m=a_pose[None, :3])
        for a_pose, q, side, name in zip(pose, q_m, sides, names, strict=True)
    ]


def _draw(machine: Machine, meshes: tuple[BodyMesh, ...], stances: list[Stance], tcp_m: FloatArray) -> Figure:
    low, high = drawn_window(machine, meshes, stances, tcp_m)
    columns = min(5 if len(stances) > 12 else 4, len(stances))
    rows = -(-len(stances) // columns)
    size = high - low + np.array([0.0, _TITLE_M * min(1.0, columns / 4.0)])
    scale = (style.WIDTH_IN - 0.06) / (columns * size[0])
    figure = style.new_figure(float(rows * size[1] * scale + 0.45))
    axes = figure.subplots()
    axes.set_axis_off()
    for number, stance in enumerate(stances):
        row, column = divmod(number, columns)
        origin = np.array([column, -row]) * size - low
        draw_machine(axes, machine, meshes, stance, origin)
        axes.text(
            origin[0] + low[0] + size[0] / 2.0,
            origin[1] + high[1],
            stance.title,
            fontsize=style.SMALL_TEXT_PT,
            ha="center",
            va="bottom",
        )
    _draw_triad(axes, project(_triad_place(machine, stances[0].sides)) - low)
    axes.set_xlim(0.0, columns * size[0])
    axes.set_ylim(-(rows - 1) * size[1], size[1])
    axes.set_aspect("equal")
    way = any(len(stance.way_m) > 1 for stance in stances)
    rods = any(mesh.is_link for mesh in meshes)
    figure.legend(handles=legend_handles(way, rods), loc="outside lower center", ncols=3 if rods else 4)
    return figure


def _points(machine: Machine, stance: Stance) -> DrawnPoints:
    return drawn_points(machine, stance.pose, stance.q_m)


def drawn_window(
    machine: Machine, meshes: tuple[BodyMesh, ...], stances: list[Stance], tcp_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Compute the least and largest projected coordinates of everything that is drawn, each (2,)."""
    drawn = [_points(machine, stance) for stance in stances]
    joints = [ends for points in drawn for ends in (points.cart_joints_m, points.platform_joints_m)]
    fixed = [mesh.vertices_m for mesh in meshes if mesh.kind == FrameKind.FIXED]
    parts = [rail_ends(machine), tcp_m, *joints, *fixed]
    seen = np.concatenate([project(part).reshape(-1, 2) for part in parts])
    return seen.min(axis=0) - _MARGIN_M / 2.0, seen.max(axis=0) + _MARGIN_M / 2.0


def draw_machine(
    axes: Axes, machine: Machine, meshes: tuple[BodyMesh, ...], stance: Stance, origin: FloatArray
) -> None:
    """Draw a machine at an origin (2,) of the drawing: its bodies, and lines for what has none."""
    points = _points(machine, stance)
    colours = [_COLOURS[side] for side in stance.sides]
    of_link = [colours[arm] for arm in ARM_OF_LINK]
    kinds = {mesh.kind for mesh in meshes}
    tcp = project(stance.way_m) + origin
    rails = project(rail_ends(machine)) + origin
    axes.add_collection(LineCollection(list(rails), colors=style.GREY, linewidths=1.2, zorder=1.0))
    if FrameKind.PLATFORM not in kinds:
        corners = np.vstack([stance.pose[:3], points.platform_joints_m])
        bars = project(corners[platform_bars(machine)]) + origin
        axes.add_collection(LineCollection(list(bars), zorder=2.0, **_PLATFORM))
    if not any(mesh.is_link for mesh in meshes):
        links = project(np.stack([points.cart_joints_m, points.platform_joints_m], axis=1)) + origin
        for which, look in ((_FIXED, _LINK), (TELESCOPES, _TELESCOPE)):
            lines = LineCollection([links[k] for k in which], colors=[of_link[k] for k in which], zorder=3.0, **look)
            axes.add_collection(lines)
    feet = project(points.feet_m) + origin
    beams = np.stack([feet[ARM_OF_LINK], project(points.cart_joints_m) + origin], axis=1)
    axes.add_collection(LineCollection(list(beams), colors=style.BLACK, linewidths=0.9, zorder=3.5))
    seen = silhouettes(meshes, stance.pose, points)
    around = [one for one in seen if one.mesh.is_around]
    for bodies, zorder in ((around, 0.5), ([one for one in seen if one not in around], 3.7)):
        faces = [_body_colour(one.mesh, colours) for one in bodies]
        outlines = [one.outline + origin for one in bodies]
        axes.add_collection(PolyCollection(outlines, facecolors=faces, edgecolors=faces, linewidths=0.1, zorder=zorder))
    if FrameKind.CART not in kinds:
        for foot, colour in zip(feet, colours, strict=True):
            axes.plot(
                *foot, "s", color=colour, markersize=2.6, markeredgecolor=style.BLACK, markeredgewidth=0.4, zorder=4.0
            )
    axes.plot(*tcp.T, color=style.VERMILLION, linewidth=0.6, zorder=4.0)
    axes.plot(*tcp[-1], "o", color=style.VERMILLION, markersize=1.8, zorder=5.0)


def _body_colour(mesh: BodyMesh, colours: list[str]) -> tuple[float, float, float]:
    """Colour links and carts by arm, what slides out of a tube brighter; platform and rails are grey."""
    if mesh.kind == FrameKind.PLATFORM:
        return to_rgb(_PLATFORM["color"])
    if mesh.kind == FrameKind.FIXED:
        return to_rgb(_FLOOR if mesh.is_around else style.GREY)
    arm = int(ARM_OF_LINK[mesh.number]) if mesh.kind == FrameKind.LINK else mesh.number
    is_rod = mesh.kind == FrameKind.LINK and mesh.number in TELESCOPES and bool(mesh.shares.any())
    return _brighter(colours[arm]) if is_rod else to_rgb(colours[arm])


def _brighter(colour: str) -> tuple[float, float, float]:
    red, green, blue = to_rgb(colour)
    return (red + 1.0) / 2.0, (green + 1.0) / 2.0, (blue + 1.0) / 2.0


def _triad_place(machine: Machine, sides: FloatArray) -> FloatArray:
    """Choose a place for the axes of the first machine: above rail 3, away from its arm. Shape (3,)."""
    least, largest = machine.travel_m[2]
    part = 0.8 if sides[2] < 0.0 else 0.0
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
            zorder=6.0,
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


def legend_handles(way: bool, rods: bool) -> list[Line2D]:
    """Make the legend of drawn machines: whether paths of the TCP, and rods as bodies, are drawn."""
    tcp = Line2D([], [], color=style.VERMILLION, linewidth=0.6, label="way of the TCP")
    if not way:
        tcp = Line2D([], [], color=style.VERMILLION, marker="o", markersize=1.8, linestyle="none", label="TCP")
    return [
        Line2D([], [], color=_COLOURS[-1.0], label="arm left (L)", **_LINK),
        Line2D([], [], color=_COLOURS[1.0], label="arm right (R)", **_LINK),
        Line2D([], [], color=_brighter(_COLOURS[-1.0]), label="rod of a telescope", **_LINK)
        if rods
        else Line2D([], [], color=style.BLACK, label="telescope", **_TELESCOPE),
        Line2D([], [], label="platform", **_PLATFORM),
        Line2D([], [], color=style.GREY, linewidth=1.2, label="rail"),
        tcp,
        Line2D([], [], marker="$\\rightarrow$", linestyle="none", color=style.BLACK, label="axes, 0.5 m long"),
    ]
