"""Boxes to avoid: no pose of an admitted move is inside, whatever x does."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.config import BoxConfig
from pipeline.errors import NoSolutionError
from pipeline.limits.avoid import Box
from pipeline.route import build_regions, plan_route
from pipeline.route.regions.boxes import crossings, cut_windows

STEPS = np.array([0.1, 0.1, 0.1, 0.2, 0.2])


def test_a_box_has_radians_and_no_bounds_where_none_are_given():
    """Degrees are turned, what is left out is infinite; its surface is not inside."""
    box = Box.of(BoxConfig(y_m=(0.1, 0.2), rx_deg=(-10.0, 10.0)))
    np.testing.assert_allclose(box.low, [-np.inf, 0.1, -np.inf, -np.pi / 18.0, -np.inf])
    np.testing.assert_allclose(box.high, [np.inf, 0.2, np.inf, np.pi / 18.0, np.inf])
    poses = np.array([[9.0, 0.15, -3.0, 0.1, 1.0], [0.0, 0.2, 0.0, 0.0, 0.0], [0.0, 0.15, 0.0, 0.2, 0.0]])
    assert box.inside(poses).tolist() == [True, False, False]
    assert np.sign(box.depth_m(poses)).tolist() == [1.0, 0.0, -1.0]
    assert box.grown(STEPS).inside(poses).all()


@pytest.fixture(scope="module")
def table(hand_table):
    """Give a function that makes a table of random regions around the origin, ends far away."""

    def make(seed, n=30):
        random = np.random.default_rng(seed)
        low = random.uniform(-0.3, 0.2, n)
        windows = np.column_stack([low, low + random.uniform(0.0, 0.4, n)])
        regions = hand_table(windows, np.arange(n))
        controlled = np.zeros((n, 5))
        controlled[:, 1:3] = random.integers(-3, 4, (n, 2)) * 0.1
        controlled[:, 3:] = random.integers(-1, 2, (n, 2)) * 0.2
        return replace(regions, controlled=controlled)

    return make


BOX = st.tuples(st.floats(-0.2, 0.1), st.floats(0.05, 0.3), st.floats(-0.25, 0.1), st.floats(0.05, 0.3), st.booleans())


@settings(max_examples=100)
@given(st.integers(0, 10_000), BOX)
def test_no_pose_of_a_clear_move_is_inside(table, seed, sides):
    """Moves of cut regions that do not cross, at random x within their windows, sampled densely; both ends, too."""
    x, wide, y, deep, tilted = sides
    low = np.array([x, y, -0.15, -0.1 if tilted else -np.inf, -np.inf])
    box = Box(low, np.array([x + wide, y + deep, 0.15, 0.3 if tilted else np.inf, np.inf]))
    regions = cut_windows([box], table(seed), STEPS)
    near = np.abs(regions.controlled[:, None, 1:] - regions.controlled[None, :, 1:]) <= STEPS[1:] + 1e-9
    source, target = np.nonzero(near.all(axis=2))
    clear = ~crossings([box], regions, STEPS, source, target)
    random = np.random.default_rng(seed)
    for i, j in zip(source[clear].tolist(), target[clear].tolist(), strict=True):
        ends = regions.controlled[[i, j]].copy()
        ends[:, 0] = random.uniform(*regions.x_window_m[[i, j]].T)
        part = np.linspace(0.0, 1.0, 60)[:, None]
        assert not (box.depth_m(ends[0] + part * (ends[1] - ends[0])) > 1e-6).any()


@settings(max_examples=50)
@given(st.integers(0, 10_000), BOX)
def test_cutting_loses_nothing_outside(table, seed, sides):
    """Every pose of a region that is outside is in a piece of it, and what is inside is in none."""
    x, wide, y, deep, _ = sides
    box = Box(np.array([x, y, -0.15, -np.inf, -np.inf]), np.array([x + wide, y + deep, 0.15, np.inf, np.inf]))
    whole = table(seed)
    pieces = cut_windows([box], whole, STEPS)
    for row in range(len(whole)):
        same = pieces.kappa == whole.kappa[row]
        for position in np.linspace(*whole.x_window_m[row], 7):
            pose = whole.controlled[row].copy()
            pose[0] = position
            within = (pieces.x_window_m[:, 0] <= position) & (position <= pieces.x_window_m[:, 1]) & same
            assert within.any() == (box.depth_m(pose) <= 1e-9)


@pytest.fixture(scope="module")
def around(quick_config, vary):
    """Put a box where the best route of the quick task goes."""
    return vary(quick_config, {"task.avoid": [{"x_m": [0.9, 1.2], "y_m": [0.45, 0.95], "z_m": [0.2, 0.8]}]})


def test_a_route_goes_around_a_box(around, quick, assert_rules):
    """It costs more than without, and no pose of its followed moves is inside."""
    regions = build_regions(around, quick.machine)
    route = plan_route(around, quick.machine, regions)
    assert_rules(around, quick.machine, route)
    assert route.objective > 274.2
    box = Box.of(around.task.avoid[0])
    assert not box.inside(route.pose[:, [0, 1, 2, 3, 5]]).any()


def test_a_wall_leaves_no_route(quick_config, quick, vary):
    """A box of any x, z and tilt between start and goal, neither of them near it: proven."""
    config = vary(quick_config, {"task.goal.y_m": 0.6})
    assert plan_route(config, quick.machine, build_regions(config, quick.machine)).objective > 0.0
    config = vary(config, {"task.avoid": [{"y_m": [0.4, 0.5]}]})
    with pytest.raises(NoSolutionError, match="proven"):
        plan_route(config, quick.machine, build_regions(config, quick.machine))


@pytest.mark.parametrize("margin", [0.0, 0.25])
def test_moves_are_admitted_for_every_x_of_their_windows(quick_config, quick, vary, assert_rules, margin):
    """What is admitted does not depend on the x that a solver happens to take: one round does, and the proof holds."""
    box = {"x_m": [0.95, 1.25], "y_m": [0.58, 0.98], "z_m": [0.54, 0.94]}
    config = vary(quick_config, {"task.avoid": [box], "route.avoid_margin": margin, "task.tilt_max_deg": 10})
    regions = build_regions(config, quick.machine)
    route = plan_route(config, quick.machine, regions)
    assert_rules(config, quick.machine, route)
    assert route.search.rounds == 1
