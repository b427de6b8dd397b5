"""An atlas as matrices: a row per station where motions begin, a column per station where they end."""

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.atlas.matrix import Matrix
from pipeline.figures import style

_COLOURS = "YlGnBu"
_DARK = 0.6
"""Part of the range of colours from which on text is white."""
_CELL_IN, _LEAST_IN = 0.3, 0.9
_MOST_WRITTEN = 12
"""Stations up to which every cell is written into."""


@style.styled
def atlas_figure(matrices: list[Matrix]) -> Figure:
    """Draw matrices one below the other; cells without a figure are grey, and say why."""
    height = max(_LEAST_IN, _CELL_IN * len(matrices[0].names))
    figure = style.new_figure(len(matrices) * (height + 0.7))
    panels = figure.subplots(len(matrices), 1, squeeze=False)[:, 0]
    for axes, matrix in zip(panels, matrices, strict=True):
        _draw(axes, matrix)
    return figure


def _draw(axes: Axes, matrix: Matrix) -> None:
    size = len(matrix.names)
    known = np.isfinite(matrix.values)
    least, largest = (matrix.values[known].min(), matrix.values[known].max()) if known.any() else (0.0, 1.0)
    colours = colormaps[_COLOURS].with_extremes(bad=style.LIGHT_GREY)
    shown = np.ma.masked_invalid(matrix.values)
    image = axes.imshow(shown, cmap=colours, vmin=least, vmax=max(largest, least + 1e-9), aspect="auto")
    axes.figure.colorbar(image, ax=axes, pad=0.02)
    axes.grid(visible=False)
    axes.set_xticks(range(size), matrix.names, rotation=45, ha="right")
    axes.set_yticks(range(size), matrix.names)
    axes.set_title(f"{matrix.title}; from (row) to (column)")
    if size > _MOST_WRITTEN:
        return
    for row in range(size):
        for column in range(size):
            part = (matrix.values[row, column] - least) / max(largest - least, 1e-9)
            axes.text(
                column,
                row,
                matrix.texts[row][column],
                ha="center",
                va="center",
                fontsize=style.SMALL_TEXT_PT,
                color="white" if part > _DARK else style.BLACK,
            )
