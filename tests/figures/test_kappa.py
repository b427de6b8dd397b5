"""kappa along the coarse and the refined path."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.figure import Figure

from pipeline.config import Config
from pipeline.figures.kappa import kappa_figure
from pipeline.refine.measure import PathSamples, measure_path
from pipeline.route.metric import step_sizes
from pipeline.route.result import Route


@pytest.fixture(scope="module")
def figure(agder_config: Config, route: Route, coarse: PathSamples, refined: PathSamples) -> Figure:
    """Draw both paths."""
    return kappa_figure(agder_config, route, coarse, refined)


def test_curves_end_at_the_measured_lengths(
    figure: Figure, agder_config: Config, coarse: PathSamples, refined: PathSamples
) -> None:
    """Both curves run from zero to the path's length in steps, and their area is the integral in the legend."""
    axes = figure.axes[1]
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    for line, samples, name in zip(axes.get_lines()[:2], (coarse, refined), names[:2], strict=True):
        figures = measure_path(samples, step_sizes(agder_config.route))
        x, y = line.get_data()
        assert (x[0], x[-1]) == (0.0, pytest.approx(figures.length))
        assert f"integral {figures.kappa_integral:.1f}" in name
        assert f"largest {figures.kappa_max:.2f}" in name
        np.testing.assert_array_equal(y, samples.kappa)


def test_the_gain_has_a_sign(figure: Figure) -> None:
    """The refined path's entry says by how many per cent its integral is lower."""
    assert "(−" in figure.legends[0].get_texts()[1].get_text()


def test_axes_have_units(figure: Figure) -> None:
    """Length is in steps, kappa has the unit of its moments."""
    assert figure.axes[1].get_xlabel() == "length along the path (steps)"
    assert figure.axes[1].get_ylabel() == "κ (moments in m)"


def test_steps_of_the_route_lie_on_the_coarse_curve(figure: Figure, route: Route) -> None:
    """There is a dot per step, at the kappa of that step."""
    corners = figure.axes[1].get_lines()[2]
    np.testing.assert_allclose(corners.get_ydata(), route.kappa, rtol=1e-9)


def test_maxima_are_labelled_at_the_maxima(figure: Figure, coarse: PathSamples, refined: PathSamples) -> None:
    """A label per path, above both curves and each at its own height."""
    labels = figure.axes[1].texts
    assert [label.get_text() for label in labels] == [f"{samples.kappa.max():.1f}" for samples in (coarse, refined)]
    heights = [label.xyann[1] for label in labels]
    assert heights[0] > heights[1] > max(coarse.kappa.max(), refined.kappa.max())
    assert [label.xy[1] for label in labels] == [coarse.kappa.max(), refined.kappa.max()]
    assert figure.axes[1].get_ylim()[1] > heights[0]


def test_a_path_in_one_mode_has_one_strip_per_arm(figure: Figure) -> None:
    """Six strips, L all along."""
    strips = figure.axes[0]
    assert len(strips.patches) == 6
    assert [text.get_text() for text in strips.texts] == ["L"] * 6


def test_mode_changes_are_where_the_cart_passes_the_joint(
    agder_config: Config, route: Route, coarse: PathSamples, refined: PathSamples
) -> None:
    """Moving cart 2 to the other side for the last part of the path splits its strip there and nowhere else."""
    q_m = coarse.q_m.copy()
    q_m[100:, 1] += 2.0
    changed = kappa_figure(agder_config, route, dataclasses.replace(coarse, q_m=q_m), refined)
    strips = changed.axes[0]
    bars = [bar for bar in strips.patches if round(bar.get_y() + 0.45, 3) == 1.0]
    length = changed.axes[1].get_lines()[0].get_xdata()
    assert [(bar.get_x(), bar.get_x() + bar.get_width()) for bar in bars] == [
        (0.0, pytest.approx(length[100])),
        (pytest.approx(length[100]), pytest.approx(length[-1])),
    ]
    assert len(strips.patches) == 7
    assert [text.get_text() for text in strips.texts][1:3] == ["L", "R"]


def test_short_stretches_get_no_letter(
    agder_config: Config, route: Route, coarse: PathSamples, refined: PathSamples
) -> None:
    """A mode that lasts for two samples of 141 is drawn without a letter that would not fit."""
    q_m = coarse.q_m.copy()
    q_m[100:102, 1] += 2.0
    strips = kappa_figure(agder_config, route, dataclasses.replace(coarse, q_m=q_m), refined).axes[0]
    assert len(strips.patches) == 8
    assert {text.get_text() for text in strips.texts} == {"L"}


def test_nothing_overlaps(figure: Figure, assert_laid_out: Callable[[Figure], None]) -> None:
    """Labels, strips and legend keep off each other and stay on the page."""
    assert_laid_out(figure)
