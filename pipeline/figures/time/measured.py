"""A measured motion and the commanded one, as in Fig. 8 of the paper, and the errors beside them."""

from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from pipeline.figures import style
from pipeline.measured.comparison import COORDINATES, Coordinate, MeasurementComparison

_SHOWN = 40
"""Number of measured points drawn over a commanded curve: more would hide it."""
_SHORTEST_S = 1e-3
"""Least time shown, for a measurement of a single instant."""
_BAND = 2.0
"""Half width of the band of noise in standard deviations."""


class Drawn(NamedTuple):
    """How the other motion is called, and when working modes change, if that is known."""

    name: str
    changes_s: tuple[float, ...] = ()


def measured_figure(comparison: MeasurementComparison) -> Figure:
    """Draw x, y, z, rx, rz over time: commanded and measured on the left, their difference on the right.

    On the left some of the measured points are shown, on the right all of them, with a band of two standard deviations
    of their noise if it is known. The legend counts rows of the file that were skipped for a gap.
    """
    return motion_figure(comparison, Drawn("measured"))


@style.styled
def motion_figure(comparison: MeasurementComparison, drawn: Drawn) -> Figure:
    """Draw a figure as `measured_figure`, of another motion; mode changes are vertical lines."""
    figure = style.new_figure(5.6)
    panels = figure.subplots(len(COORDINATES), 2, sharex=True)
    for index, (row, coordinate) in enumerate(zip(panels, COORDINATES, strict=True)):
        _draw_motion(row[0], comparison, index, coordinate)
        _draw_error(row[1], comparison, index, coordinate)
    panels[0, 0].set_title("motion")
    panels[0, 1].set_title(f"{drawn.name} - commanded")
    for axes in panels.flat:
        style.mark_changes(axes, drawn.changes_s)
    for axes in panels[-1]:
        axes.set_xlabel("time (s)")
        axes.set_xlim(0.0, max(float(comparison.t_s[-1]), _SHORTEST_S))
        axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    for column in panels.T:
        figure.align_ylabels(column)
    handles = _handles(comparison, drawn)
    figure.legend(handles=handles, loc="outside lower center", ncols=3 if len(handles) < 4 else 2)
    return figure


def _draw_motion(axes: Axes, comparison: MeasurementComparison, index: int, coordinate: Coordinate) -> None:
    angle = coordinate.unit == "deg"
    scale = coordinate.scale if angle else 1.0
    every = max(len(comparison.t_s) // _SHOWN, 1)
    axes.plot(comparison.t_s, scale * comparison.commanded[:, index], color=style.COARSE, linewidth=0.8)
    axes.plot(comparison.t_s[::every], scale * comparison.measured[::every, index], **_dots())
    axes.set_ylabel(f"{coordinate.name} ({'deg' if angle else 'm'})")
    axes.yaxis.set_major_locator(style.angle_locator() if angle else MaxNLocator(4))


def _draw_error(axes: Axes, comparison: MeasurementComparison, index: int, coordinate: Coordinate) -> None:
    scale = coordinate.scale
    if comparison.std is not None:
        half = _BAND * scale * comparison.std[:, index]
        axes.fill_between(comparison.t_s, -half, half, color=style.SKY_BLUE, alpha=0.5, linewidth=0.0)
    axes.plot(comparison.t_s, scale * comparison.error[:, index], color=style.REFINED, linewidth=0.5)
    axes.axhline(0.0, color=style.COARSE, linewidth=0.5)
    axes.set_ylabel(f"{coordinate.name} ({coordinate.unit})")
    axes.yaxis.set_major_locator(MaxNLocator(4))


def _dots() -> dict[str, Any]:
    return {
        "color": style.REFINED,
        "linestyle": "none",
        "marker": "o",
        "fillstyle": "none",
        "markersize": 2.2,
        "markeredgewidth": 0.6,
    }


def _handles(comparison: MeasurementComparison, drawn: Drawn) -> list[Line2D | Patch]:
    """Make entries for both motions, and for mode changes, the band of noise and rows with gaps if there are any."""
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=style.COARSE, label="commanded"),
        Line2D([], [], label=drawn.name, **_dots()),
    ]
    if drawn.changes_s:
        handles.append(style.change_handle())
    if comparison.std is not None:
        handles.append(Patch(facecolor=style.SKY_BLUE, alpha=0.5, label="two standard deviations of noise"))
    if comparison.account is not None and (gaps := comparison.account.gap_count):
        handles.append(Line2D([], [], linestyle="none", label=f"left out: {gaps:,} row{'s'[: gaps > 1]} with gaps"))
    return handles
