"""The route over maps of kappa."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from pipeline.config import Config
from pipeline.figures.maps.kappa_map import kappa_map
from pipeline.figures.maps.route import MAX_PANELS, route_figure, select_steps
from pipeline.machine import MODES, Machine
from pipeline.refine.measure import PathSamples
from pipeline.route.result import Route


@pytest.fixture(scope="module")
def figure(agder_config: Config, machine: Machine, route: Route, coarse: PathSamples, refined: PathSamples) -> Figure:
    """Draw a route with a panel for each step."""
    return route_figure(agder_config, machine, route, coarse, refined)


@pytest.fixture(scope="module")
def tilted_route(machine: Machine, route: Route) -> Route:
    """Give three steps: LLL without tilt, then LRR at -10 and -30 degrees, where det H = 0 within reach."""
    pose = route.pose[[0, 1, 2]].copy()
    pose[0, [3, 5]], pose[1:, [3, 5]] = 0.0, np.deg2rad([-10.0, -30.0])
    modes = np.array([MODES.index("LLL"), MODES.index("LRR"), MODES.index("LRR")])
    return dataclasses.replace(first_steps(route, 3), pose=pose, modes=modes)


def first_steps(route: Route, count: int) -> Route:
    """Cut a route short."""
    names = ("region", "modes", "gates", "pose", "q_m", "kappa")
    return dataclasses.replace(route, **{name: getattr(route, name)[:count] for name in names})


def panels_of(figure: Figure) -> list[Axes]:
    """Give the axes that show maps, without the colour bar."""
    return [axes for axes in figure.axes if axes.get_images()]


def image_of(axes: Axes) -> AxesImage:
    """Give a panel's map."""
    return axes.get_images()[0]


def loops_of(axes: Axes) -> list[ContourSet]:
    """Give a panel's contours."""
    return [artist for artist in axes.get_children() if isinstance(artist, ContourSet)]


def test_a_panel_per_step_chosen(figure: Figure, route: Route) -> None:
    """A panel for each step and a colour bar, titled with step, working mode, kappa and tilts."""
    panels = panels_of(figure)
    assert len(panels) == len(route)
    assert len(figure.axes) == len(route) + 1
    for axes, step in zip(panels, select_steps(route, MAX_PANELS), strict=True):
        assert axes.get_title().startswith(f"{step}  LLL  κ {route.kappa[step]:.1f}\nrx ")
    assert panels[0].get_title().endswith("rx 0°  rz 0°")


def test_axes_have_units(figure: Figure) -> None:
    """The outer panels and the colour bar say what they show and in which unit."""
    panels = panels_of(figure)
    assert {axes.get_ylabel() for axes in panels[::4]} == {"z (m)"}
    assert {axes.get_xlabel() for axes in panels[-4:]} == {"y (m)"}
    assert {axes.get_ylabel() for axes in panels[1::4]} == {""}
    assert figure.axes[-1].get_xlabel() == "κ, the condition number of H (moments in m)"


def test_no_panel_is_empty_and_all_share_one_scale(figure: Figure, agder_config: Config) -> None:
    """Every map has values, on one logarithmic scale that ends at the cap on kappa."""
    norms = {id(image_of(axes).norm) for axes in panels_of(figure)}
    assert len(norms) == 1
    norm = image_of(figure.axes[0]).norm
    assert isinstance(norm, LogNorm)
    assert norm.vmax == agder_config.route.kappa_max
    for axes in panels_of(figure):
        values = np.ma.filled(image_of(axes).get_array(), np.nan)
        assert np.isfinite(values).any()
        assert np.nanmin(values) >= norm.vmin
        assert np.isnan(values).any()
        assert axes.patch.get_hatch()


def test_pixels_are_centred_on_the_map_points(figure: Figure, machine: Machine, route: Route) -> None:
    """The pixel under a step's own pose holds nearly the kappa of that step."""
    for axes, step in zip(panels_of(figure), select_steps(route, MAX_PANELS), strict=True):
        image = image_of(axes)
        left, right, bottom, top = image.get_extent()
        rows, columns = image.get_array().shape
        y, z = route.pose[step, 1:3]
        column, row = int((y - left) / (right - left) * columns), int((z - bottom) / (top - bottom) * rows)
        assert image.get_array()[row, column] == pytest.approx(route.kappa[step], rel=0.01)
        edge_y = left + (np.array([column, column + 1]) * (right - left) / columns)
        a_map = kappa_map(machine, edge_y.mean(keepdims=True), np.array([z]), tuple(route.pose[step, [3, 5]]), 0)
        assert a_map.kappa[0, 0] == pytest.approx(image.get_array()[row, column], rel=0.01)


def test_the_route_so_far_ends_at_the_step(figure: Figure, route: Route) -> None:
    """The thick line grows from panel to panel, and the mark is where it ends; everything lies in the window."""
    lengths = []
    for axes, step in zip(panels_of(figure), select_steps(route, MAX_PANELS), strict=True):
        lines = {line.get_label(): line for line in axes.get_lines()}
        so_far, here = lines["route so far"].get_xydata(), axes.get_lines()[-1].get_xydata()[0]
        np.testing.assert_allclose(so_far[0], route.pose[0, 1:3], atol=1e-12)
        np.testing.assert_allclose(so_far[-1], route.pose[step, 1:3], atol=1e-12)
        np.testing.assert_allclose(here, route.pose[step, 1:3])
        np.testing.assert_allclose(lines["start"].get_xydata()[0], route.pose[0, 1:3])
        np.testing.assert_allclose(lines["goal"].get_xydata()[0], route.pose[-1, 1:3])
        lengths.append(len(so_far))
        assert axes.get_xlim()[0] < so_far[:, 0].min() <= so_far[:, 0].max() < axes.get_xlim()[1]
        assert axes.get_ylim()[0] < so_far[:, 1].min() <= so_far[:, 1].max() < axes.get_ylim()[1]
    assert lengths == sorted(set(lengths))


def test_loops_only_where_det_changes_sign(agder_config: Config, machine: Machine, tilted_route: Route) -> None:
    """No loop at LLL without tilt; at LRR every vertex lies between two points in reach with opposite signs."""
    panels = panels_of(route_figure(agder_config, machine, tilted_route, None, None))
    assert [len(loops_of(axes)) for axes in panels] == [0, 1, 1]
    image = image_of(panels[1])
    left, right, bottom, top = image.get_extent()
    rows, columns = image.get_array().shape
    pixel = np.array([(right - left) / columns, (top - bottom) / rows])
    y_m = left + pixel[0] * (np.arange(columns) + 0.5)
    z_m = bottom + pixel[1] * (np.arange(rows) + 0.5)
    det = kappa_map(machine, y_m, z_m, (np.deg2rad(-10.0), np.deg2rad(-30.0)), MODES.index("LRR")).det
    (path,) = loops_of(panels[1])[0].get_paths()
    assert len(path.vertices) > 50
    for place in (path.vertices - [y_m[0], z_m[0]]) / pixel:
        lower, upper = np.floor(place + 1e-6).astype(int), np.ceil(place - 1e-6).astype(int)
        assert det[lower[1], lower[0]] * det[upper[1], upper[0]] < 0.0


def test_the_real_zero_is_on_the_loop(agder_config: Config, machine: Machine, tilted_route: Route) -> None:
    """At the vertices of a loop H is nearly singular: kappa is far above the cap."""
    axes = panels_of(route_figure(agder_config, machine, tilted_route, None, None))[1]
    (path,) = loops_of(axes)[0].get_paths()
    tilt = (np.deg2rad(-10.0), np.deg2rad(-30.0))
    for y, z in path.vertices[5:-5:20]:
        kappa = kappa_map(machine, np.array([y]), np.array([z]), tilt, MODES.index("LRR")).kappa[0, 0]
        assert kappa > 5.0 * agder_config.route.kappa_max


@pytest.mark.parametrize(("steps", "panels"), [(1, 1), (2, 2), (4, 4)])
def test_short_routes_have_a_panel_per_step(
    agder_config: Config, machine: Machine, route: Route, steps: int, panels: int
) -> None:
    """A route alone, without paths, is drawn through its steps; panels that are not needed are not there."""
    figure = route_figure(agder_config, machine, first_steps(route, steps), None, None)
    assert len(panels_of(figure)) == len(figure.axes) - 1 == panels
    last = panels_of(figure)[-1]
    assert "refined path" not in [line.get_label() for line in last.get_lines()]
    assert len(last.get_lines()[0].get_xydata()) == steps


def test_a_low_cap_still_gives_a_scale(agder_config: Config, machine: Machine, route: Route) -> None:
    """A cap below every kappa of the maps leaves a valid colour scale."""
    low = agder_config.model_copy(update={"route": agder_config.route.model_copy(update={"kappa_max": 10.0})})
    norm = image_of(route_figure(low, machine, first_steps(route, 2), None, None).axes[0]).norm
    assert (norm.vmin, norm.vmax) == (5.0, 10.0)


def test_nothing_overlaps(figure: Figure, assert_laid_out: Callable[[Figure], None]) -> None:
    """Titles, labels, colour bar and legend keep off each other and stay on the page."""
    assert_laid_out(figure)


@given(kappa=st.lists(st.floats(1.0, 100.0), min_size=1, max_size=40), count=st.integers(3, 12))
def test_selection_has_first_last_and_worst(route: Route, kappa: list[float], count: int) -> None:
    """Whatever the route: in order, without repetition, no more than asked for, all of them when they fit."""
    n = len(kappa)
    indices = np.zeros(n, dtype=np.int64)
    steps = select_steps(dataclasses.replace(route, region=indices, kappa=np.array(kappa)), count)
    assert len(steps) == min(n, count)
    assert (np.diff(steps) > 0).all()
    assert {0, n - 1, int(np.argmax(kappa))} <= set(steps.tolist())
