"""Parameters of a calibration: what each changed by, and how surely, beside what was known of it beforehand."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pipeline.calibrate import Calibration
from pipeline.calibrate.model.parameters import CLOCKS, OFFSETS, PLATFORM
from pipeline.calibrate.report import FROM_DATA, FROM_PRIOR, sources
from pipeline.figures import style

_ROW_IN = 0.103
_MILLIONTHS = 1e6
_NAME_PT = 5.0
_COLOURS = {FROM_DATA: style.BLUE, FROM_PRIOR: style.ORANGE}
_UNITS = {"m": "μm", "1": "ppm", "rad": "μrad"}
_FACES = {FROM_DATA: style.BLUE, FROM_PRIOR: "white"}


@style.styled
def parameters_figure(calibration: Calibration) -> Figure:
    """Draw the change of every fitted parameter with its deviation, over a grey bar of what was known beforehand.

    Joints are on the left, all else on the right; the tracker's frame and clocks are left out. Both columns have one
    scale, in millionths of SI units.
    """
    found = calibration.identification
    parameters, fitted = found.model.parameters, found.problem.is_fitted
    joints = parameters.slice(OFFSETS).stop
    columns = [
        [k for k in range(first, last) if fitted[k]]
        for first, last in ((parameters.slice(PLATFORM).start, joints), (joints, parameters.slice(CLOCKS).start))
    ]
    columns = [rows for rows in columns if rows]
    figure = style.new_figure(0.65 + _ROW_IN * max(len(rows) for rows in columns))
    panels = figure.subplots(1, len(columns), sharex=True, squeeze=False)[0]
    for axes, rows in zip(panels, columns, strict=True):
        _draw(axes, calibration, rows)
        axes.set_ylim(max(len(rows) for rows in columns) - 0.4, -0.6)
    reach = _MILLIONTHS * max(float(np.max(np.abs(found.theta[rows]) + found.std[rows])) for rows in columns)
    panels[0].set_xlim(-1.05 * reach, 1.05 * reach)
    figure.legend(handles=_handles(), loc="outside lower center", ncols=3)
    return figure


def _draw(axes: Axes, calibration: Calibration, rows: Sequence[int]) -> None:
    found = calibration.identification
    origins, parameters = sources(calibration), found.model.parameters
    names = parameters.names
    prior = _MILLIONTHS * found.problem.prior_std[rows]
    axes.barh(range(len(rows)), 2.0 * prior, left=-prior, height=0.72, color=style.LIGHT_GREY)
    axes.axvline(0.0, color=style.BLACK, linewidth=0.5)
    for place, k in enumerate(rows):
        axes.errorbar(
            _MILLIONTHS * found.theta[k],
            place,
            xerr=_MILLIONTHS * found.std[k],
            fmt="o",
            color=_COLOURS[origins[k]],
            markerfacecolor=_FACES[origins[k]],
            markersize=2.6,
            markeredgewidth=0.7,
            elinewidth=0.9,
        )
        if place and _kind(names[k]) != _kind(names[rows[place - 1]]):
            axes.axhline(place - 0.5, color=style.GREY, linewidth=0.4)
    units = {parameters.units[k]: _UNITS[parameters.units[k]] for k in rows}
    axes.set_xlabel(f"change ({', '.join(units.values())})")
    axes.set_yticks(range(len(rows)), [names[k] for k in rows], fontsize=_NAME_PT)
    axes.tick_params(axis="y", length=0.0)
    axes.grid(visible=False, axis="y")


def _kind(name: str) -> str:
    """Give the words of a name before its subject."""
    return name.split(" ")[0]


def _handles() -> list[Line2D | Patch]:
    marks: list[Line2D | Patch] = [
        Line2D([], [], color=_COLOURS[source], marker="o", markerfacecolor=_FACES[source], label=source)
        for source in (FROM_DATA, FROM_PRIOR)
    ]
    return [*marks, Patch(facecolor=style.LIGHT_GREY, label="known beforehand")]
