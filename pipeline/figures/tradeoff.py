"""Trade-offs: duration over the integral and over the largest kappa, a curve per route."""

from itertools import groupby

from matplotlib.figure import Figure

from pipeline.figures import style
from pipeline.tradeoff import TradeoffPoint
from pipeline.tradeoff.table import weight_text

_COLOURS = (style.BLUE, style.VERMILLION, style.GREEN, style.PURPLE, style.ORANGE, style.SKY_BLUE, style.BLACK)
_MARKERS = "osD^v<>PXp"


@style.styled
def tradeoff_figure(points: tuple[TradeoffPoint, ...]) -> Figure:
    """Draw the points of every route, joined in the order of their weights, which stand beside them."""
    figure = style.new_figure(2.6)
    axes = figure.subplots(1, 2, sharey=True)
    for index, (_, members) in enumerate(groupby(points, key=lambda point: point.route)):
        curve = list(members)
        duration = [point.duration_s for point in curve]
        text = f"route {curve[0].route}: {' '.join(curve[0].modes)}"
        look = {"color": _COLOURS[index % len(_COLOURS)], "marker": _MARKERS[index], "label": text}
        for ax, name in zip(axes, ("kappa_integral", "kappa_max"), strict=True):
            values = [getattr(point, name) for point in curve]
            ax.plot(values, duration, **look)
            # Room for the weights beside the outermost points.
            ax.margins(0.15)
            for point, x, y in zip(curve, values, duration, strict=True):
                ax.annotate(
                    weight_text(point.weight),
                    (x, y),
                    textcoords="offset points",
                    xytext=(3, 3),
                    fontsize=style.SMALL_TEXT_PT,
                )
    axes[0].set_ylabel("duration (s)")
    axes[0].set_xlabel("integral of κ (steps)")
    axes[1].set_xlabel("largest κ")
    figure.legend(handles=axes[0].get_legend_handles_labels()[0], loc="outside lower center", ncols=1)
    return figure
