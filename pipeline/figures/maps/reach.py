"""What can be reached when there is no route: a panel per working mode in the YZ plane, all tilts overlaid."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import Config
from pipeline.figures import style
from pipeline.limits.actuator_margins import controlled_pose
from pipeline.machine.geometry import MODES
from pipeline.route.regions.table import RegionTable

_COLUMNS = 4
_CLASSES = (
    (style.LIGHT_GREY, "cut off from both"),
    (style.SKY_BLUE, "reached from the start"),
    (style.ORANGE, "leads to the goal"),
    (style.YELLOW, "either, at different tilts"),
    (style.PURPLE, "both"),
)
_NEITHER, _START, _GOAL, _EITHER, _BOTH = range(len(_CLASSES))
_MARKS = (("start", "o", "full"), ("goal", "s", "none"))
_ROUNDING = 1e-9


@style.styled
def reach_figure(config: Config, regions: RegionTable, from_start: BoolArray, to_goal: BoolArray) -> Figure:
    """Draw the regions (n,) that can be reached from the start, those that can reach the goal, and the rest.

    A cell of the grid counts if one of its regions does, whatever its tilt. Gates count for the grid point below and
    to the left of them. Working modes without regions are omitted.
    """
    modes = np.unique(regions.modes)
    columns = min(_COLUMNS, len(modes))
    rows = -(-len(modes) // columns)
    cells = _cells(config, regions)
    maps = [_classify(cells, regions.modes == mode, from_start, to_goal) for mode in modes]
    window = _window(config, regions)
    width, height = np.diff(window, axis=1).ravel()
    figure = style.new_figure(style.panels_height_in(height / width, rows, columns, 0.65, 0.2, 0.6))
    panels = list(figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).flat)
    for axes, mode, a_map in zip(panels, modes, maps, strict=False):
        _draw_panel(axes, config, int(mode), a_map)
        axes.set(xlim=window[0], ylim=window[1])
    for axes in panels[len(modes) :]:
        axes.remove()
    style.label_yz_panels(panels[: len(modes)], columns)
    figure.legend(handles=_legend_handles(maps), loc="outside lower center", ncols=3)
    return figure


def _cells(config: Config, regions: RegionTable) -> tuple[IntArray, IntArray, tuple[int, int]]:
    """Compute the column (y) and row (z) of every region, clipped to the grid, and the shape (z, y) of a map."""
    indices, counts = [], []
    for axis, column in (("y_m", 1), ("z_m", 2)):
        grid = getattr(config.route.grid, axis)
        count = int(np.floor((grid.max - grid.min) / grid.step + _ROUNDING)) + 1
        index = np.floor((regions.controlled[:, column] - grid.min) / grid.step + _ROUNDING).astype(np.int64)
        indices.append(np.clip(index, 0, count - 1))
        counts.append(count)
    return indices[0], indices[1], (counts[1], counts[0])


def _classify(
    cells: tuple[IntArray, IntArray, tuple[int, int]], here: BoolArray, from_start: BoolArray, to_goal: BoolArray
) -> FloatArray:
    """Classify every cell, by the index into `_CLASSES`; NaN where there is no region. Shape (z, y)."""
    y, z, shape = cells

    def marked(rows: BoolArray) -> BoolArray:
        found = np.zeros(shape, dtype=bool)
        found[z[rows & here], y[rows & here]] = True
        return found

    start, goal = marked(from_start), marked(to_goal)
    values = np.where(marked(here), float(_NEITHER), np.nan)
    values[start] = _START
    values[goal] = _GOAL
    values[start & goal] = _EITHER
    values[marked(from_start & to_goal)] = _BOTH
    return values


def _window(config: Config, regions: RegionTable) -> FloatArray:
    """Compute the least and largest y and z of the cells with regions: rows y and z, in metres."""
    yz = regions.controlled[:, 1:3]
    margin = np.array([config.route.grid.y_m.step, config.route.grid.z_m.step])
    return np.stack([yz.min(axis=0) - margin, yz.max(axis=0) + margin], axis=1)


def _draw_panel(axes: Axes, config: Config, mode: int, a_map: FloatArray) -> None:
    y, z = config.route.grid.y_m, config.route.grid.z_m
    rows, columns = a_map.shape
    axes.grid(False)
    axes.imshow(
        a_map,
        cmap=ListedColormap([colour for colour, _ in _CLASSES]),
        norm=BoundaryNorm(np.arange(len(_CLASSES) + 1) - 0.5, len(_CLASSES)),
        origin="lower",
        extent=(
            y.min - 0.5 * y.step,
            y.min + (columns - 0.5) * y.step,
            z.min - 0.5 * z.step,
            z.min + (rows - 0.5) * z.step,
        ),
        interpolation="nearest",
    )
    axes.set_title(MODES[mode])
    for name, marker, fill in _MARKS:
        end = getattr(config.task, name)
        if end.mode == MODES[mode]:
            axes.plot(*controlled_pose(end)[1:3], **_mark(marker, fill))


def _mark(marker: str, fill: str) -> dict[str, Any]:
    return {
        "marker": marker,
        "fillstyle": fill,
        "color": style.BLACK,
        "markersize": 4.0,
        "markeredgewidth": 0.9,
        "linestyle": "none",
    }


def _legend_handles(maps: list[FloatArray]) -> list[Patch | Line2D]:
    """Make entries for the classes that occur, and for both ends."""
    present = {int(value) for a_map in maps for value in np.unique(a_map[np.isfinite(a_map)])}
    handles: list[Patch | Line2D] = [
        Patch(facecolor=colour, label=label) for number, (colour, label) in enumerate(_CLASSES) if number in present
    ]
    return handles + [Line2D([], [], label=name, **_mark(marker, fill)) for name, marker, fill in _MARKS]
