"""Maps of kappa as pictures: one style for all figures that show them, and a figure of maps only."""

from collections.abc import Iterable, Mapping
from typing import Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from pipeline.arguments import require_number
from pipeline.errors import ArgumentError
from pipeline.figures import style
from pipeline.figures.maps.kappa_map import KappaMap

COLORMAP = "Blues"
_LOOP_COLOUR = style.YELLOW
_HATCH = "//////"
_COLUMNS = 4


@style.styled
def kappa_map_figure(maps: Mapping[str, KappaMap], kappa_max: float = 100.0) -> Figure:
    """Draw maps of kappa side by side under their titles, in one colour scale that ends at `kappa_max`.

    Dark is near a Type-II singularity, the yellow loops are det H = 0, the hatched area is out of reach.

    Raises
    ------
    ArgumentError
        If there is no map, or `kappa_max` is not more than one.
    """
    if not maps:
        raise ArgumentError("maps: expected at least one")
    kappa_max = require_number("kappa_max", kappa_max, above=1.0)
    columns = min(_COLUMNS, len(maps))
    rows = -(-len(maps) // columns)
    first = next(iter(maps.values()))
    panel_in = (style.WIDTH_IN - 0.5) / columns * float(np.ptp(first.z_m) / np.ptp(first.y_m))
    figure = style.new_figure(rows * (panel_in + 0.2) + 0.95)
    panels = list(figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).flat)
    norm = map_norm(maps.values(), kappa_max)
    for axes, (title, a_map) in zip(panels, maps.items(), strict=False):
        draw_map(axes, a_map, norm)
        axes.set_title(title, fontsize=style.SMALL_TEXT_PT)
    for axes in panels[len(maps) :]:
        axes.remove()
    style.label_yz_panels(panels[: len(maps)], columns)
    add_kappa_bar(figure, panels[: len(maps)], norm, first.moment_unit, extend="max")
    figure.legend(handles=map_handles(), loc="outside lower center", ncols=2)
    return figure


def map_norm(maps: Iterable[KappaMap], kappa_max: float) -> LogNorm:
    """Scale colours from the least kappa of all maps to the cap, beyond which everything is dark."""
    least = min((float(np.nanmin(a.kappa)) for a in maps if np.isfinite(a.kappa).any()), default=1.0)
    return LogNorm(min(least, 0.5 * kappa_max), kappa_max)


def draw_map(axes: Axes, a_map: KappaMap, norm: LogNorm) -> None:
    """Draw kappa in colours, det H = 0 as lines, and hatch what is out of reach."""
    axes.grid(False)
    axes.set_facecolor(style.LIGHT_GREY)
    axes.patch.set(hatch=_HATCH, edgecolor="white", linewidth=0.0)
    axes.imshow(
        a_map.kappa,
        norm=norm,
        cmap=COLORMAP,
        origin="lower",
        extent=_extent(a_map),
        interpolation="nearest",
    )
    if a_map.has_singularities:
        axes.contour(
            a_map.y_m,
            a_map.z_m,
            a_map.det,
            levels=[0.0],
            colors=_LOOP_COLOUR,
            linewidths=0.9,
            corner_mask=False,
        )


def _extent(a_map: KappaMap) -> tuple[float, float, float, float]:
    """Compute the edges of the image whose pixels are centred on the points of the map."""
    y, z = a_map.y_m, a_map.z_m
    half_y, half_z = 0.5 * (y[1] - y[0]), 0.5 * (z[1] - z[0])
    return float(y[0] - half_y), float(y[-1] + half_y), float(z[0] - half_z), float(z[-1] + half_z)


def add_kappa_bar(
    figure: Figure, panels: list[Axes], norm: LogNorm, unit: str, extend: Literal["neither", "max"] = "neither"
) -> None:
    """Add the colour bar of kappa below the panels; `unit` is that of its moments."""
    bar = figure.colorbar(
        ScalarMappable(norm, COLORMAP), ax=panels, location="bottom", extend=extend, aspect=35, pad=0.02, shrink=0.9
    )
    bar.set_label(f"κ, the condition number of H ({unit})")
    bar.ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0, 7.0)))
    bar.ax.xaxis.set_minor_locator(NullLocator())
    bar.ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def map_handles() -> list[Patch]:
    """Make the legend's entries of a map: singularities, and what is out of reach."""
    return [
        Patch(facecolor=mpl.colormaps[COLORMAP](1.0), edgecolor=_LOOP_COLOUR, label="det H = 0"),
        Patch(facecolor=style.LIGHT_GREY, edgecolor="white", hatch=_HATCH, linewidth=0.0, label="out of reach"),
    ]
