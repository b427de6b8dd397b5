"""One style for all figures: the colours, and sizes that can be read at half a page width.

Figures are laid out at the width at which they are read, half an A4 page, with text of at least 6 points. The settings
apply while a figure is built (`styled`); matplotlib's own stay as they are.
"""

from collections.abc import Callable, Iterable
from functools import wraps
from typing import Any, ParamSpec

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

P = ParamSpec("P")

WIDTH_IN = 3.5
"""Width of every figure in inches."""
DPI = 300

# The palette of Okabe and Ito, which is safe for colour-blind readers.
BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
GREEN = "#009E73"
YELLOW = "#F0E442"
BLUE = "#0072B2"
VERMILLION = "#D55E00"
PURPLE = "#CC79A7"
GREY = "#7F7F7F"
LIGHT_GREY = "#DDDDDD"

COARSE = BLACK
REFINED = VERMILLION
LIMIT_LINE: dict[str, Any] = {"color": GREY, "linestyle": (0, (4, 2)), "linewidth": 0.8}
CHANGE_LINE: dict[str, Any] = {"color": GREY, "linestyle": (0, (1, 1.5)), "linewidth": 0.7}

LENGTH_LABEL = "length along the path (steps)"

TEXT_PT = 7
SMALL_TEXT_PT = 6

_STYLE: dict[Any, Any] = {
    "font.size": TEXT_PT,
    "axes.titlesize": TEXT_PT,
    "axes.labelsize": TEXT_PT,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.labelpad": 2.0,
    "axes.titlepad": 3.0,
    "grid.linewidth": 0.4,
    "grid.color": "#E5E5E5",
    "lines.linewidth": 1.0,
    "lines.markersize": 3.0,
    "hatch.linewidth": 0.4,
    "legend.fontsize": SMALL_TEXT_PT,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.0,
    "legend.borderpad": 0.2,
    "xtick.labelsize": SMALL_TEXT_PT,
    "ytick.labelsize": SMALL_TEXT_PT,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.0,
    "ytick.major.size": 2.0,
    "xtick.major.pad": 2.0,
    "ytick.major.pad": 2.0,
}


def styled(build: Callable[P, Figure]) -> Callable[P, Figure]:
    """Build a figure in this style, without changing matplotlib's own settings."""

    @wraps(build)
    def in_style(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with mpl.rc_context(_STYLE):
            return build(*args, **kwargs)

    return in_style


def new_figure(height_in: float) -> Figure:
    """Make an empty figure of the common width that lays itself out without overlaps."""
    layout = ConstrainedLayoutEngine(w_pad=0.03, h_pad=0.03, wspace=0.02, hspace=0.02)
    return Figure(figsize=(WIDTH_IN, height_in), dpi=DPI, layout=layout)


def panels_height_in(aspect: float, rows: int, columns: int, beside: float, above: float, around: float) -> float:
    """Compute the height of a figure of equal panels; `aspect` is the height over the width of one.

    In inches: `beside` is the width that is not panels, `above` the title of each row, `around` the rest of the height.
    """
    return rows * ((WIDTH_IN - beside) / columns * aspect + above) + around


def label_yz_panels(panels: list[Axes], columns: int) -> None:
    """Label the outer YZ planes of a grid of panels, and leave the inner ones without ticks."""
    for number, axes in enumerate(panels):
        axes.label_outer(remove_inner_ticks=True)
        if number % columns == 0:
            axes.set_ylabel("z (m)")
        if number + columns >= len(panels):
            axes.tick_params(bottom=True, labelbottom=True)
            axes.set_xlabel("y (m)")


def name_lines(axes: Axes, count: int) -> None:
    """Put the names of the curves above the panel, where they cover nothing."""
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.02), ncols=count, handlelength=1.0, borderaxespad=0.0)


def angle_locator() -> MaxNLocator:
    """Place ticks at multiples of 15 or 30 degrees rather than 20 or 25."""
    return MaxNLocator(5, steps=[1, 1.5, 3, 5, 10])


def count_locator() -> MaxNLocator:
    """Place ticks at whole numbers that one counts in: ones, twos, fives, tens."""
    return MaxNLocator(8, steps=[1, 2, 5, 10], integer=True)


def mark_changes(axes: Axes, t_s: Iterable[float]) -> None:
    """Draw a vertical line at every change of the working mode."""
    for t in t_s:
        axes.axvline(t, **CHANGE_LINE)


def change_handle() -> Line2D:
    """Make the entry of mode changes for a legend."""
    return Line2D([], [], label="mode change", **CHANGE_LINE)
