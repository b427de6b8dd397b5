"""The phase plane: path speed along the path, below the maximum-velocity curve."""

import numpy as np
from matplotlib.figure import Figure

from pipeline.figures import style
from pipeline.retime.constraints import largest_speed, limit_rows
from pipeline.retime.path_dynamics import TABLE_POINTS, dynamics_table, grid
from pipeline.retime.result import Trajectory

_PLACES = 1_501
_HEADROOM = 1.35


@style.styled
def phase_figure(trajectory: Trajectory) -> Figure:
    """Draw sd over s, the maximum-velocity curve, and the caps of the velocity limits alone.

    Below the maximum-velocity curve some path acceleration keeps accelerations and forces within their limits; jerk is
    not considered.
    """
    s = grid(_PLACES)
    rows = limit_rows(dynamics_table(trajectory.path, TABLE_POINTS).at(s))
    top = largest_speed(rows)
    t = np.linspace(0.0, trajectory.duration_s, 4 * _PLACES)
    speed = trajectory.s(t, 1)
    figure = style.new_figure(2.4)
    axes = figure.subplots()
    axes.fill_between(s, top, 1e3 * top.max(), color=style.LIGHT_GREY, linewidth=0.0)
    axes.plot(s, rows.cap, color=style.SKY_BLUE, linewidth=0.8, label="velocity limits")
    axes.plot(s, top, color=style.BLACK, linewidth=0.8, label="maximum-velocity curve")
    axes.plot(trajectory.s(t), speed, color=style.VERMILLION, label="trajectory")
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(0.0, _HEADROOM * float(max(speed.max(), np.quantile(top, 0.9))))
    axes.set_xlabel("path parameter s")
    axes.set_ylabel("path speed ds/dt (1/s)")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure
