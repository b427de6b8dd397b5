"""The regions among which the route is chosen."""

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure

from pipeline.config import Config
from pipeline.figures.maps.regions import regions_figure
from pipeline.machine import MODES, Machine
from pipeline.route import RegionTable, build_regions


@pytest.fixture(scope="module")
def regions(quick_config: Config, machine: Machine) -> RegionTable:
    """Compute the regions of the coarse grid."""
    return build_regions(quick_config, machine)


@pytest.fixture(scope="module")
def figure(quick_config: Config, regions: RegionTable) -> Figure:
    """Draw them."""
    return regions_figure(quick_config, regions)


def discs_of(axes: Axes) -> EllipseCollection:
    """Give a panel's discs."""
    (discs,) = [artist for artist in axes.collections if isinstance(artist, EllipseCollection)]
    return discs


def test_a_panel_per_working_mode(figure: Figure, regions: RegionTable) -> None:
    """Eight panels that name the mode and count all its regions, and a colour bar."""
    counts = [np.count_nonzero(regions.modes == mode) for mode in range(8)]
    assert [axes.get_title() for axes in figure.axes[:8]] == [
        f"{name}  {count:,}" for name, count in zip(MODES, counts, strict=True)
    ]
    assert figure.axes[8].get_xlabel() == "κ, the condition number of H (moments in m)"


def test_discs_are_the_regions_without_tilt(figure: Figure, regions: RegionTable) -> None:
    """Places and kappa are the table's; gates are dots, and not among the discs."""
    flat = np.abs(regions.controlled[:, 3:]).max(axis=1) < 1e-9
    for mode, axes in enumerate(figure.axes[:8]):
        here = flat & (regions.modes == mode)
        cells, discs = regions.take(here & (regions.gates == 0)), discs_of(axes)
        np.testing.assert_array_equal(discs.get_offsets(), cells.controlled[:, 1:3])
        np.testing.assert_array_equal(discs.get_array(), cells.kappa)
        dots = sum(len(line.get_xdata()) for line in axes.get_lines())
        assert dots == np.count_nonzero(here & (regions.gates > 0)) > 0
        assert len(cells) > 0


def test_all_is_in_sight_and_nothing_overlaps(figure: Figure, assert_laid_out: Callable[[Figure], None]) -> None:
    """The window holds every disc; panels, labels, colour bar and legend keep off each other."""
    for axes in figure.axes[:8]:
        y, z = np.asarray(discs_of(axes).get_offsets()).T
        assert axes.get_xlim()[0] < y.min() <= y.max() < axes.get_xlim()[1]
        assert axes.get_ylim()[0] < z.min() <= z.max() < axes.get_ylim()[1]
    assert_laid_out(figure)


def test_modes_without_regions_are_left_out(quick_config: Config, regions: RegionTable) -> None:
    """A table of two modes has two panels; the legend says what tilt is drawn."""
    figure = regions_figure(quick_config, regions.take(regions.modes % 7 == 0))
    assert [axes.get_title()[:3] for axes in figure.axes[:-1]] == ["LLL", "RRR"]
    assert figure.legends[0].get_title().get_text() == "drawn: rx 0°, rz 0°; numbers: regions at all tilts"
