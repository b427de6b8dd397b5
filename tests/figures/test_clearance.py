"""Clearance and tilt along both paths."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.config import Config
from pipeline.figures.clearance import clearance_figure
from pipeline.machine import Machine, link_rail_distances
from pipeline.refine.measure import PathSamples


@pytest.fixture(scope="module")
def figure(agder_config: Config, machine: Machine, coarse: PathSamples, refined: PathSamples) -> Figure:
    """Draw both paths."""
    return clearance_figure(agder_config, machine, coarse, refined)


def limits_of(axes: Axes) -> list[float]:
    """Give the heights of the dashed lines."""
    return [float(line.get_ydata()[0]) for line in axes.get_lines()[2:]]


def test_limits_are_drawn(figure: Figure) -> None:
    """Clearance 0.03 m, all of what holding may take, tilts 30 degrees both ways, all within the panels."""
    distance, force, rx, rz = figure.axes
    assert limits_of(distance) == [0.03]
    assert limits_of(force) == [1.0]
    assert limits_of(rx) == limits_of(rz) == [-30.0, 30.0]
    for axes in figure.axes:
        assert all(axes.get_ylim()[0] < limit < axes.get_ylim()[1] for limit in limits_of(axes))


def test_curves_are_the_samples(figure: Figure, coarse: PathSamples, refined: PathSamples) -> None:
    """Distances as they are, the largest share of a force limit, tilts in degrees."""
    distance, force, rx, rz = figure.axes
    limits, _ = refined.machine.force_limits_n
    for k, samples in enumerate((coarse, refined)):
        np.testing.assert_array_equal(distance.get_lines()[k].get_ydata(), samples.link_distance_m)
        shares = np.abs(samples.holding_forces_n) / limits
        np.testing.assert_allclose(force.get_lines()[k].get_ydata(), shares.max(axis=1))
        np.testing.assert_allclose(rx.get_lines()[k].get_ydata(), np.rad2deg(samples.pose[:, 3]))
        np.testing.assert_allclose(rz.get_lines()[k].get_ydata(), np.rad2deg(samples.pose[:, 5]))


def test_axes_have_units(figure: Figure) -> None:
    """Metres, shares, degrees, steps."""
    labels = ["least link-link\ndistance (m)", "holding\nforce (of allowed)", "rx (deg)", "rz (deg)"]
    assert [axes.get_ylabel() for axes in figure.axes] == labels
    assert figure.axes[-1].get_xlabel() == "length along the path (steps)"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["coarse path", "refined path", "limit"]


def test_rails_are_shown_when_they_are_checked(
    agder_config: Config, machine: Machine, coarse: PathSamples, refined: PathSamples
) -> None:
    """A configured distance to rails adds a panel with its limit."""
    checked = dataclasses.replace(machine, link_rail_m=0.05)
    axes = clearance_figure(agder_config, checked, coarse, refined).axes
    assert len(axes) == 5
    assert axes[1].get_ylabel() == "least link-rail\ndistance (m)"
    assert limits_of(axes[1]) == [0.05]
    np.testing.assert_array_equal(
        axes[1].get_lines()[1].get_ydata(), link_rail_distances(machine, refined.pose, refined.carts_m).min(axis=1)
    )


def test_a_locked_axis_has_its_tolerance_as_limit(
    agder_config: Config, machine: Machine, coarse: PathSamples, refined: PathSamples
) -> None:
    """With rz locked its limit is how far it may stray from zero."""
    locked = agder_config.model_copy(update={"task": agder_config.task.model_copy(update={"locked_axes": ("rz",)})})
    axes = clearance_figure(locked, machine, coarse, refined).axes
    assert limits_of(axes[2]) == [-30.0, 30.0]
    assert limits_of(axes[3]) == [-0.25, 0.25]


def test_nothing_overlaps(figure: Figure, assert_laid_out: Callable[[Figure], None]) -> None:
    """Panels, labels and legend keep off each other and stay on the page."""
    assert_laid_out(figure)
