"""The corridor around the route."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.file import parse_config
from pipeline.limits.avoid import Box
from pipeline.machine import Machine
from pipeline.machine.pose import CONTROLLED, TILT_COLUMNS
from pipeline.refine import Path, coarse_path, refine_path
from pipeline.refine.coarse import move_of
from pipeline.refine.corridor.cells import corridor, visit_parameters
from pipeline.refine.measure import sample_path
from pipeline.route import Route, build_regions, plan_route

S = np.linspace(0.0, 1.0, 101)


def test_it_holds_the_coarse_path(quick_config: Config, route: Route, coarse: Path) -> None:
    """With one cell to spare the way it was found is inside everywhere."""
    bounds = corridor(quick_config, route, coarse, S)
    pose = coarse.pose(S)
    tolerance = np.deg2rad(quick_config.route.follow.tilt_overshoot_deg)
    assert (pose >= bounds.low - tolerance).all()
    assert (pose <= bounds.high + tolerance).all()


def test_start_and_goal_are_exact(quick_config: Config, route: Route, coarse: Path) -> None:
    """The ends leave no freedom."""
    bounds = corridor(quick_config, route, coarse, S)
    for row in (0, -1):
        np.testing.assert_array_equal(bounds.low[row], route.pose[row])
        np.testing.assert_array_equal(bounds.high[row], route.pose[row])


def test_no_tilt_beyond_its_limit_less_the_margin(quick_config: Config, route: Route, coarse: Path) -> None:
    """Tilts are cut off at the limit."""
    refine = quick_config.refine.model_copy(update={"tilt_margin_deg": 2.0})
    bounds = corridor(quick_config.model_copy(update={"refine": refine}), route, coarse, S)
    limit = np.deg2rad(28.0) + 1e-12
    for column in TILT_COLUMNS:
        assert bounds.high[:, column].max() <= limit
        assert bounds.low[:, column].min() >= -limit


def test_a_locked_axis_keeps_within_its_tolerance(quick_config: Config, route: Route, coarse: Path) -> None:
    """The box of a locked axis is its tolerance, whatever the route does."""
    task = quick_config.task.model_copy(update={"locked_axes": ("rx",)})
    bounds = corridor(quick_config.model_copy(update={"task": task}), route, coarse, S[1:-1])
    assert np.rad2deg(bounds.high[1:-1, 3].max()) < quick_config.refine.lock_tolerance_deg
    assert np.rad2deg(bounds.low[1:-1, 3].min()) > -quick_config.refine.lock_tolerance_deg


@pytest.mark.parametrize("cells", [0.0, 2.0])
def test_every_cell_widens_it_by_one_grid_step(
    quick_config: Config, route: Route, coarse: Path, steps: np.ndarray, cells: float
) -> None:
    """In y and z, where nothing else cuts, the box of a node in one move grows by the cells less what it may bulge."""
    refine = quick_config.refine.model_copy(update={"corridor_cells": cells})
    bounds = corridor(quick_config.model_copy(update={"refine": refine}), route, coarse, S)
    move = move_of(coarse, S)
    inside = np.flatnonzero((move[:-2] == move[1:-1]) & (move[1:-1] == move[2:])) + 1
    narrow = np.abs(np.diff(route.pose[:, 1:3], axis=0))[move[inside]]
    widths = (bounds.high - bounds.low)[inside, 1:3] - 2.0 * cells * steps[1:3]
    np.testing.assert_allclose(widths, narrow - (0.04 if cells else 0.0) * steps[1:3], atol=1e-12)


def test_a_margin_wider_than_the_corridor_leaves_a_tilt_without_freedom(
    quick_config: Config, route: Route, coarse: Path
) -> None:
    """Where the route itself tilts beyond the limit less the margin, the box is that limit and never empty."""
    refine = quick_config.refine.model_copy(update={"corridor_cells": 0.0, "tilt_margin_deg": 15.0})
    bounds = corridor(quick_config.model_copy(update={"refine": refine}), route, coarse, S)
    assert (bounds.low <= bounds.high).all()
    assert np.rad2deg(np.abs(bounds.low[1:-1, TILT_COLUMNS]).max()) <= 15.0 + 1e-9


@pytest.fixture(scope="module")
def errand(quick_config: Config) -> Config:
    """Ask for a visit and for a box to keep out of, by the route whose optimum is proven soonest."""
    visit = {"pose": {"x_m": 1.0, "y_m": 0.6, "z_m": 0.7, "mode": "RLL"}}
    task = {
        **quick_config.task.model_dump(),
        "visit": [visit, {"box": {"x_m": [0.9, 1.1], "y_m": [0.6, 0.9]}}],
        "avoid": [{"y_m": [0.4, 0.5], "z_m": [0.9, 1.0]}],
    }
    route = {**quick_config.route.model_dump(), "objective": "sum"}
    return parse_config({**quick_config.model_dump(), "task": task, "route": route})


@pytest.fixture(scope="module")
def errand_route(errand: Config, machine: Machine) -> Route:
    """Plan it."""
    return plan_route(errand, machine, build_regions(errand, machine))


def test_visits_and_boxes_narrow_it(errand: Config, machine: Machine, errand_route: Route, steps: np.ndarray) -> None:
    """A pose to visit is exact at a node of its own, a box to visit bounds its node, none is in one to avoid."""
    coarse = coarse_path(machine, errand_route, steps)
    at = visit_parameters(coarse, errand_route)
    s = np.union1d(S, at)
    bounds = corridor(errand, errand_route, coarse, s)
    first, second = np.searchsorted(s, at)
    np.testing.assert_array_equal(bounds.low[first], bounds.high[first])
    np.testing.assert_allclose(bounds.low[first, [0, 1, 2, 3, 5]], [1.0, 0.6, 0.7, 0.0, 0.0])
    assert bounds.low[second, 1] >= 0.6
    assert bounds.high[second, 0] <= 1.1
    box = Box.of(errand.task.avoid[0])
    # Every node is kept beyond one side of the box.
    beyond = (bounds.high[:, CONTROLLED] <= box.low) | (bounds.low[:, CONTROLLED] >= box.high)
    assert beyond.any(axis=1).all()


@pytest.mark.slow
def test_a_path_makes_its_visit_and_keeps_out_of_the_box(errand: Config, machine: Machine, errand_route: Route) -> None:
    """Looked at densely, from start to goal, on the first mesh."""
    refine = errand.refine.model_copy(update={"max_meshes": 1})
    path = refine_path(errand.model_copy(update={"refine": refine}), machine, errand_route).path
    samples = sample_path(path, np.linspace(0.0, 1.0, 20_001))
    assert not Box.of(errand.task.avoid[0]).inside(samples.pose[:, CONTROLLED]).any()
    at = path.pose(path.node_s)
    assert np.abs(at[:, :3] - [1.0, 0.6, 0.7]).max(axis=1).min() < 1e-7
