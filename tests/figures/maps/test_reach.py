"""The picture of what can be reached."""

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.config import Config
from pipeline.figures import style
from pipeline.figures.maps.reach import reach_figure
from pipeline.machine import MODES, Machine
from pipeline.route import RegionTable, build_regions


@pytest.fixture(scope="module")
def flat(quick_config: Config) -> Config:
    """Take the coarse grid without tilt: a few hundred regions."""
    return quick_config.model_copy(update={"task": quick_config.task.model_copy(update={"tilt_max_deg": 0.0})})


@pytest.fixture(scope="module")
def regions(flat: Config, machine: Machine) -> RegionTable:
    """Compute the regions of `flat`."""
    return build_regions(flat, machine)


def none_of(regions: RegionTable) -> np.ndarray:
    """Mark no region."""
    return np.zeros(len(regions), dtype=bool)


def values_of(axes: Axes) -> np.ndarray:
    """Give the classes a panel shows, NaN where no region is."""
    return np.ma.filled(axes.get_images()[0].get_array().astype(float), np.nan)


def labels_of(figure: Figure) -> list[str]:
    """Give the legend's texts."""
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_a_panel_per_working_mode(flat: Config, regions: RegionTable) -> None:
    """Eight panels in the order of the modes, axes with units on the outside, the ends where they belong."""
    figure = reach_figure(flat, regions, regions.modes < 4, regions.modes >= 4)
    assert [axes.get_title() for axes in figure.axes] == list(MODES)
    assert [axes.get_ylabel() for axes in figure.axes] == (["z (m)"] + [""] * 3) * 2
    assert [axes.get_xlabel() for axes in figure.axes] == [""] * 4 + ["y (m)"] * 4
    marked = {axes.get_title(): axes.lines[0].get_xydata().tolist() for axes in figure.axes if axes.lines}
    assert marked == {"LLL": [[0.3, 0.9]], "RRR": [[0.3, 0.9]]}
    assert [set(np.unique(values_of(axes)[np.isfinite(values_of(axes))])) for axes in figure.axes] == (
        [{1.0}] * 4 + [{2.0}] * 4
    )
    assert labels_of(figure) == ["reached from the start", "leads to the goal", "start", "goal"]
    assert figure.get_figwidth() == style.WIDTH_IN


def test_modes_without_regions_are_left_out(flat: Config, regions: RegionTable) -> None:
    """Five modes fill two rows of panels, and none is empty."""
    few = regions.take(np.isin(regions.modes, [0, 2, 3, 5, 7]))
    figure = reach_figure(flat, few, none_of(few), none_of(few))
    assert [axes.get_title() for axes in figure.axes] == ["LLL", "LRL", "LRR", "RLR", "RRR"]
    assert labels_of(figure) == ["cut off from both", "start", "goal"]


def test_cells_are_those_of_the_regions(flat: Config, regions: RegionTable) -> None:
    """A panel has as many cells of a class as grid points or gates with it, projected over tilt."""
    from_start, to_goal = none_of(regions), none_of(regions)
    rows = np.flatnonzero((regions.modes == 0) & (regions.gates == 0))[:3]
    from_start[rows[:2]] = True
    to_goal[rows[1:]] = True
    values = values_of(reach_figure(flat, regions, from_start, to_goal).axes[0])
    assert [(values == kind).sum() for kind in (1.0, 2.0, 3.0, 4.0)] == [1, 1, 0, 1]
    y, z = flat.route.grid.y_m, flat.route.grid.z_m
    place = regions.controlled[rows, 1:3]
    columns, heights = ((place - [y.min, z.min]) / [y.step, z.step]).round().astype(int).T
    assert values[heights, columns].tolist() == [1.0, 4.0, 2.0]


def test_different_tilts(flat: Config, regions: RegionTable) -> None:
    """A cell reached at one tilt that leads to the goal at another is distinguished from one that does both."""
    row = int(np.flatnonzero((regions.modes == 0) & (regions.gates == 0))[0])
    twice = regions.take(np.array([row, row, *range(len(regions))]))
    from_start, to_goal = none_of(twice), none_of(twice)
    from_start[0] = to_goal[1] = True
    figure = reach_figure(flat, twice, from_start, to_goal)
    assert (values_of(figure.axes[0]) == 3.0).sum() == 1
    assert "either, at different tilts" in labels_of(figure)
