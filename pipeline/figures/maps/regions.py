"""The regions a route is chosen from: a plane of the grid in every working mode (as in Fig. 3 of the paper)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.figures import style
from pipeline.figures.maps.panels import COLORMAP, add_kappa_bar
from pipeline.machine.geometry import MODES, build_machine
from pipeline.machine.statics import moment_unit
from pipeline.route.regions.table import RegionTable

_COLUMNS = 4
_GATE_COLOURS = {1: style.VERMILLION, 2: style.GREEN, 3: style.PURPLE}
_SAME_RAD = 1e-9
_MARGIN_M = 0.08


@style.styled
def regions_figure(config: Config, regions: RegionTable) -> Figure:
    """Draw the regions at the smallest tilt, a panel per working mode.

    A region is a disc as wide as the grid's steps, coloured by kappa; a gate, where an arm changes its mode, is a dot.
    Modes without regions at this tilt are left out.
    """
    shown = _slice(regions)
    modes = np.unique(shown.modes)
    columns = min(_COLUMNS, len(modes))
    rows = -(-len(modes) // columns)
    window = _window(shown.controlled[:, 1:3])
    width, height = np.diff(window, axis=1).ravel()
    figure = style.new_figure(style.panels_height_in(height / width, rows, columns, 0.5, 0.18, 0.95))
    panels = list(figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).flat)
    norm = LogNorm(float(shown.kappa.min()), config.route.kappa_max)
    for axes, mode in zip(panels, modes, strict=False):
        _draw_panel(axes, config, shown.take(shown.modes == mode), norm)
        axes.set_title(f"{MODES[mode]}  {np.count_nonzero(regions.modes == mode):,}", fontsize=style.SMALL_TEXT_PT)
        axes.set(xlim=window[0], ylim=window[1], aspect="equal")
    for axes in panels[len(modes) :]:
        axes.remove()
    style.label_yz_panels(panels[: len(modes)], columns)
    add_kappa_bar(figure, panels[: len(modes)], norm, moment_unit(build_machine(config.machine)))
    rx, rz = np.rad2deg(shown.controlled[0, 3:])
    figure.legend(
        handles=_legend_handles(shown),
        loc="outside lower center",
        ncols=3,
        title=f"drawn: rx {rx:g}°, rz {rz:g}°; numbers: regions at all tilts",
        title_fontsize=style.SMALL_TEXT_PT,
    )
    return figure


def _slice(regions: RegionTable) -> RegionTable:
    """Select the regions with the rx and rz of the region with the least tilt."""
    tilts = regions.controlled[:, 3:]
    flattest = tilts[int(np.argmin(np.abs(tilts).max(axis=1)))]
    return regions.take(np.abs(tilts - flattest).max(axis=1) < _SAME_RAD)


def _window(yz: FloatArray) -> FloatArray:
    """Compute the least and largest y and z: rows y and z, in metres."""
    return np.stack([yz.min(axis=0) - _MARGIN_M, yz.max(axis=0) + _MARGIN_M], axis=1)


def _draw_panel(axes: Axes, config: Config, regions: RegionTable, norm: LogNorm) -> None:
    axes.grid(False)
    grid = config.route.grid
    cells = regions.take(regions.gates == 0)
    count = len(cells)
    discs = EllipseCollection(
        np.full(count, grid.y_m.step),
        np.full(count, grid.z_m.step),
        np.zeros(count),
        units="xy",
        offsets=cells.controlled[:, 1:3],
        offset_transform=axes.transData,
        array=cells.kappa,
        norm=norm,
        cmap=COLORMAP,
        edgecolors=style.GREY,
        linewidths=0.15,
    )
    axes.add_collection(discs)
    for arm, colour in _GATE_COLOURS.items():
        gates = regions.controlled[regions.gates == arm, 1:3]
        axes.plot(*gates.T, ".", color=colour, markersize=1.8, markeredgewidth=0.0)


def _legend_handles(regions: RegionTable) -> list[Line2D]:
    return [
        Line2D([], [], marker="o", linestyle="none", markersize=2.5, color=colour, label=f"gate of arm {arm}")
        for arm, colour in _GATE_COLOURS.items()
        if (regions.gates == arm).any()
    ]
