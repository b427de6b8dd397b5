"""The common style of the figures."""

import matplotlib as mpl
import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from pipeline.figures import style


def test_style_holds_inside_and_leaves_no_trace() -> None:
    """While a figure is built its settings differ from matplotlib's own; afterwards those are as they were."""
    before = dict(mpl.rcParams)
    seen = {}

    @style.styled
    def build() -> Figure:
        seen.update(mpl.rcParams)
        return style.new_figure(2.0)

    figure = build()
    assert seen["font.size"] == style.TEXT_PT
    assert dict(mpl.rcParams) == before
    assert plt.get_fignums() == []
    assert tuple(figure.get_size_inches()) == (style.WIDTH_IN, 2.0)


def test_style_leaves_no_trace_after_an_error() -> None:
    """A figure that fails restores the settings, too."""
    before = dict(mpl.rcParams)

    @style.styled
    def build() -> Figure:
        raise ValueError("no figure")

    with pytest.raises(ValueError, match="no figure"):
        build()
    assert dict(mpl.rcParams) == before


def test_angles_tick_at_multiples_of_fifteen() -> None:
    """Tilts up to 30 degrees are read at 15 and 30."""
    assert [tick for tick in style.angle_locator().tick_values(-30.0, 30.0) if abs(tick) <= 30.0] == [
        -30,
        -15,
        0,
        15,
        30,
    ]
