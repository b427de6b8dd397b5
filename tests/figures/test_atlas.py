"""An atlas as a picture."""

import numpy as np
import pytest

from pipeline.atlas.matrix import Matrix
from pipeline.figures.atlas import atlas_figure


def matrix(size: int, value: float = 5.0) -> Matrix:
    """Make a matrix with one reason in place of a figure."""
    values = np.full((size, size), value)
    np.fill_diagonal(values, np.nan)
    values[0, 1] = np.nan
    texts = [["" if row == column else f"{row}{column}" for column in range(size)] for row in range(size)]
    texts[0][1] = "no route"
    return Matrix("sum of kappa", [f"s{k}" for k in range(size)], values, texts)


def test_every_cell_says_what_it_is() -> None:
    """A panel per matrix, with stations as rows and columns and the texts in the cells."""
    figure = atlas_figure([matrix(3), matrix(3)])
    for axes in figure.axes[:2]:
        assert [label.get_text() for label in axes.get_xticklabels()] == ["s0", "s1", "s2"]
        assert [text.get_text() for text in axes.texts] == [cell for row in matrix(3).texts for cell in row]
        shown = axes.images[0].get_array()
        np.testing.assert_array_equal(shown.mask, np.isnan(matrix(3).values))


@pytest.mark.parametrize("value", [5.0, np.nan])
def test_figures_that_are_all_alike_or_missing_are_drawn(value: float) -> None:
    """The range of colours is never empty."""
    atlas_figure([matrix(2, value)]).canvas.draw()


def test_large_matrices_are_colours_alone() -> None:
    """Texts would not fit."""
    assert len(atlas_figure([matrix(20)]).axes[0].texts) == 0
