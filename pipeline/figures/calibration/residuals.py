"""Residuals of a calibration: how far every reflector was seen from where the calibrated machine has it."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from pipeline.calibrate import Calibration
from pipeline.figures import style

_AXES = (("x", style.BLUE, "o"), ("y", style.ORANGE, "s"), ("z", style.GREEN, "^"))
_BAND = 2.0
"""Half width of the band of noise in standard deviations."""
_HEADROOM = 1.25
"""Room above and below the largest residual, as a factor; outliers are marked there."""


@style.styled
def residuals_figure(calibration: Calibration) -> Figure:
    """Draw x, y, z of all residuals over the poses, a panel per reflector, with a band of two deviations of noise.

    Points that were left out as outliers are crosses at the upper edge: they are farther off than can be shown.
    """
    found = calibration.identification
    count = found.residual_m.shape[1]
    figure = style.new_figure(0.75 + 1.15 * count)
    panels = figure.subplots(count, 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    band_um = 1e6 * _BAND * calibration.setting.noise_m
    largest_um = max(1e6 * float(np.nanmax(np.abs(found.residual_m))), band_um) * _HEADROOM
    numbers = np.arange(1, len(found.residual_m) + 1)
    for k, axes in enumerate(panels):
        axes.axhspan(-band_um, band_um, color=style.SKY_BLUE, alpha=0.35, linewidth=0.0)
        axes.axhline(0.0, color=style.BLACK, linewidth=0.5)
        for axis, (_, colour, marker) in enumerate(_AXES):
            residual = 1e6 * found.residual_m[:, k, axis]
            axes.plot(numbers, residual, marker, color=colour, markersize=2.2, markeredgewidth=0.0)
        _mark_rejected(axes, numbers[calibration.rejected[:, k]], largest_um)
        axes.set_ylabel(f"reflector {k + 1} (μm)")
        axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    panels[0].set_ylim(-largest_um, largest_um)
    panels[-1].set_xlim(0.0, len(numbers) + 1.0)
    panels[-1].set_xlabel("pose, in the order of the files")
    panels[-1].xaxis.set_major_locator(style.count_locator())
    figure.legend(handles=_handles(int(calibration.rejected.sum())), loc="outside lower center", ncols=5)
    return figure


def _mark_rejected(axes: Axes, numbers: np.ndarray, edge_um: float) -> None:
    axes.plot(
        numbers, np.full(len(numbers), 0.93 * edge_um), "x", color=style.VERMILLION, markersize=4.0, markeredgewidth=1.0
    )


def _handles(rejected: int) -> list[Line2D | Patch]:
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=colour, marker=marker, linestyle="none", label=name) for name, colour, marker in _AXES
    ]
    handles.append(Patch(facecolor=style.SKY_BLUE, alpha=0.35, label="2 deviations of noise"))
    if rejected:
        label = f"{rejected} outlier{'s'[: rejected > 1]}"
        handles.append(Line2D([], [], color=style.VERMILLION, marker="x", linestyle="none", label=label))
    return handles
