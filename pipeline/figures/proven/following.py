"""How far drives may be off the path, over s: the proven profiles."""

import numpy as np
from matplotlib.figure import Figure

from pipeline.certify.following.steps import FollowingProfile
from pipeline.figures import style


@style.styled
def following_figure(following: FollowingProfile) -> Figure:
    """Draw the proven errors of all drives over s: with the limits kept, and with the branch kept alone.

    Dotted lines are where the least of each was stopped, and by what.
    """
    figure = style.new_figure(2.2)
    axes = figure.subplots()
    for steps, colour, name in (
        (following.on_branch_m, style.GREY, "stays regular and on its branch, limits may be broken"),
        (following.within_limits_m, style.BLUE, "limits of κ, distances and joints kept, too"),
    ):
        if np.isfinite(steps).any():
            axes.stairs(1e3 * steps, following.s, baseline=None, color=colour, linewidth=1.0, label=name)
    for limit, s in following.stops:
        axes.axvline(s, color=style.BLACK, linestyle=":", linewidth=0.8)
        side, offset = ("right", -3) if s > 0.5 else ("left", 3)
        axes.annotate(
            limit,
            (s, 0.02),
            (offset, 0),
            ("data", "axes fraction"),
            textcoords="offset points",
            ha=side,
            fontsize="small",
        )
    axes.set_ylim(bottom=0.0)
    axes.set_xlim(0.0, 1.0)
    axes.set_xlabel("s")
    axes.set_ylabel("all drives may be off by (mm)")
    figure.legend(handles=axes.get_legend_handles_labels()[0], loc="outside lower center", ncols=1)
    return figure
