"""Distances of bodies along the path."""

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.figure import Figure

from pipeline.config import Config
from pipeline.errors import ArgumentError
from pipeline.figures.bodies import bodies_figure, has_pairs
from pipeline.machine import Machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.refine.measure import PathSamples
from tests.figures.conftest import controlled_curve, make_samples


@pytest.fixture(scope="module")
def with_bodies(bodies_machine: Machine) -> PathSamples:
    """Sample a path of the machine with bodies."""
    return make_samples(bodies_machine, controlled_curve(np.linspace(0.0, 1.0, 101)))


@pytest.fixture(scope="module")
def figure(bodies_config: Config, bodies_machine: Machine, with_bodies: PathSamples) -> Figure:
    """Draw its distances."""
    return bodies_figure(bodies_config, bodies_machine, with_bodies)


def test_the_nearest_pairs_are_named(figure: Figure, bodies_machine: Machine, with_bodies: PathSamples) -> None:
    """Curves are distances in millimetres, the nearest first: eight of bodies, and below four of the obstacles."""
    for axes, bodies, count in zip(figure.axes, (bodies_machine.bodies, bodies_machine.obstacles), (8, 4), strict=True):
        assert bodies is not None
        distances = body_distances(bodies, with_bodies)
        least = distances.min(axis=0)
        curves = [line for line in axes.get_lines() if str(line.get_label()).endswith("mm)")][:-1]
        assert 0 < len(curves) <= count
        for k, curve in zip(np.argsort(least, kind="stable"), curves, strict=False):
            assert curve.get_label() == f"{bodies.names[k]} ({1e3 * least[k]:.1f} mm)"
            drawn = np.asarray(curve.get_ydata(), dtype=float)
            near = np.isfinite(drawn)
            np.testing.assert_allclose(drawn[near], 1e3 * distances[near, k], atol=1e-9)
            assert near.any()
            assert (distances[~near, k] > 0.06).all()


def test_the_limit_is_drawn(figure: Figure) -> None:
    """It is within each panel, and in its legend; the pairs that are not named are counted."""
    for axes in figure.axes:
        (limit,) = (line for line in axes.get_lines() if line.get_label() == "limit (5 mm)")
        assert list(np.asarray(limit.get_ydata())) == [5.0, 5.0]
        assert axes.get_ylim()[0] < 5.0
    legend = figure.axes[0].get_legend()
    assert legend is not None
    assert any(text.get_text().endswith("other pairs") for text in legend.get_texts())


def test_obstacles_of_the_task_are_drawn_without_bodies_of_the_machine(
    quick_config: Config, machine: Machine, refined: PathSamples, vary: Callable[..., Config]
) -> None:
    """One panel, of the TCP and the links."""
    ball = {"name": "ball", "hull": {"points_m": [[1.0, 0.0, 0.2]], "radius_m": 0.05}}
    figure = bodies_figure(vary(quick_config, {"task.obstacles": [ball]}), machine, refined)
    (axes,) = figure.axes
    assert axes.get_ylabel() == "distance from\nobstacles (mm)"
    assert any(" and ball (" in str(line.get_label()) for line in axes.get_lines())


def test_it_is_drawn_only_where_there_are_bodies(
    quick_config: Config, machine: Machine, refined: PathSamples, bodies_config: Config, with_bodies: PathSamples
) -> None:
    """A machine without bodies has no such figure, and asking for it is refused."""
    assert has_pairs(bodies_config, with_bodies.machine, with_bodies)
    assert not has_pairs(quick_config, machine, refined)
    with pytest.raises(ArgumentError, match=r"expected machine\.bodies"):
        bodies_figure(quick_config, machine, refined)


def test_nothing_overlaps(figure: Figure, assert_laid_out: Callable[[Figure], None]) -> None:
    """Panel and legend keep off each other and stay on the page."""
    assert_laid_out(figure)


def test_long_names_stay_on_the_page(
    quick_config: Config,
    machine: Machine,
    refined: PathSamples,
    vary: Callable[..., Config],
    assert_laid_out: Callable[[Figure], None],
) -> None:
    """They are below each other."""
    ball = {"name": "the-fixture-on-the-left-of-the-table", "hull": {"points_m": [[1.0, 0.0, 0.2]], "radius_m": 0.05}}
    assert_laid_out(bodies_figure(vary(quick_config, {"task.obstacles": [ball]}), machine, refined))
