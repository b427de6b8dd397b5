"""Errors over the workspace: of the machine as configured, and as calibrated, a row of two maps per working mode."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from pipeline.arrays import FloatArray
from pipeline.calibrate.predict.maps import ErrorMaps
from pipeline.figures import style

_COLOURS = "viridis_r"
_COLUMNS = 4
_MARGIN_M = 0.03
_TITLES = ("configured", "calibrated")


@style.styled
def error_maps_figure(errors: ErrorMaps) -> Figure:
    """Draw errors of reflectors over the YZ plane, a panel per working mode: as configured above, as calibrated below.

    Colours are one logarithmic scale. Dots are the poses that were measured, whatever their x and tilt.
    """
    window = _window(errors)
    width, height = np.diff(window, axis=1).ravel()
    columns = min(_COLUMNS, len(errors.maps))
    rows = -(-len(errors.maps) // columns)
    figure = style.new_figure(style.panels_height_in(height / width, 2 * rows, columns, 0.45, 0.2, 0.95))
    panels = figure.subplots(2 * rows, columns, sharex=True, sharey=True, squeeze=False)
    norm = _norm(errors)
    for half, title in enumerate(_TITLES):
        own = list(panels[half * rows : (half + 1) * rows].flat)
        for axes, one in zip(own, errors.maps, strict=False):
            axes.set_title(f"{one.mode} {title}", fontsize=style.SMALL_TEXT_PT)
            _draw(axes, errors, (one.configured_m, one.calibrated_m)[half], norm)
            if half:
                axes.plot(*one.measured_yz_m.T, ".", color=style.BLACK, markersize=2.0, markeredgewidth=0.0)
            axes.set(xlim=window[0], ylim=window[1])
        style.label_yz_panels(own[: len(errors.maps)], columns)
        for axes in own[len(errors.maps) :]:
            axes.remove()
    shown = [axes for axes in panels.flat if axes.figure is not None]
    bar = figure.colorbar(
        ScalarMappable(norm, _COLOURS), ax=shown, location="bottom", extend="both", aspect=40, pad=0.02, shrink=0.9
    )
    bar.set_label("error of reflectors, root mean square (mm)")
    bar.ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    bar.ax.xaxis.set_minor_locator(NullLocator())
    bar.ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    dot = Line2D([], [], color=style.BLACK, marker=".", linestyle="none", label="pose that was measured")
    figure.legend(handles=[dot], loc="outside lower center")
    return figure


def _draw(axes: Axes, errors: ErrorMaps, values_m: FloatArray, norm: LogNorm) -> None:
    y, z = errors.y_m, errors.z_m
    half_y, half_z = 0.5 * (y[1] - y[0]), 0.5 * (z[1] - z[0])
    axes.grid(visible=False)
    axes.imshow(
        1e3 * values_m,
        cmap=_COLOURS,
        norm=norm,
        origin="lower",
        extent=(y[0] - half_y, y[-1] + half_y, z[0] - half_z, z[-1] + half_z),
        interpolation="nearest",
    )


def _norm(errors: ErrorMaps) -> LogNorm:
    values = np.concatenate([np.stack([one.configured_m, one.calibrated_m]).ravel() for one in errors.maps])
    least, largest = np.nanpercentile(1e3 * values, [0.5, 99.5])
    return LogNorm(float(least), float(largest))


def _window(errors: ErrorMaps) -> FloatArray:
    used = np.any([np.isfinite(one.calibrated_m) for one in errors.maps], axis=0)
    measured = np.concatenate([one.measured_yz_m for one in errors.maps])
    spans = []
    for centres, along, dots in zip(
        (errors.y_m, errors.z_m), (used.any(axis=0), used.any(axis=1)), measured.T, strict=True
    ):
        shown = np.concatenate([centres[along], dots])
        spans.append((shown.min() - _MARGIN_M, shown.max() + _MARGIN_M))
    return np.array(spans)
