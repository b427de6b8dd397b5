"""What a task adds to the regions: visits as rows of their own, budgets, and all of them in one route."""

import numpy as np
import pytest

from pipeline.config.file import load_config
from pipeline.errors import ConfigError, NoSolutionError
from pipeline.machine import MODES
from pipeline.route import build_regions, plan_route, task_endpoints
from pipeline.route.search.rule_check import task_violations
from tests.conftest import CONFIGS

POSE = {"x_m": 1.0, "y_m": 0.6, "z_m": 0.7, "rx_deg": 0.0, "rz_deg": 0.0, "mode": "RLL"}


def _plan(config, machine):
    regions = build_regions(config, machine)
    return regions, plan_route(config, machine, regions)


def test_a_pose_is_visited_exactly(quick_config, vary, machine, assert_rules):
    """It is a step of the route, in its working mode and at its x."""
    config = vary(quick_config, {"task.visit": [{"pose": POSE}]})
    regions, route = _plan(config, machine)
    assert_rules(config, machine, route)
    (step,) = np.flatnonzero(route.visits)
    np.testing.assert_allclose(route.pose[step, [0, 1, 2, 3, 5]], [1.0, 0.6, 0.7, 0.0, 0.0])
    assert route.mode_names[step] == "RLL"
    assert route.objective > 274.2
    assert task_violations(config, regions, route.region, route.pose[:, 0]) == []


def test_a_box_is_visited_within_its_x_and_modes(quick_config, vary, machine, assert_rules):
    """Its rows are those of the grid with windows cut to the box."""
    box = {"x_m": [0.8, 0.9], "y_m": [0.5, 0.7]}
    config = vary(quick_config, {"task.visit": [{"box": box, "modes": ["RLL", "RRL"]}]})
    regions, route = _plan(config, machine)
    rows = regions.visits == 1
    assert rows.any()
    assert (regions.x_window_m[rows] >= 0.8).all()
    assert (regions.x_window_m[rows] <= 0.9).all()
    assert set(regions.modes[rows].tolist()) <= {MODES.index("RLL"), MODES.index("RRL")}
    assert_rules(config, machine, route)
    step = int(np.argmax(route.visits))
    assert 0.8 - 1e-9 <= route.pose[step, 0] <= 0.9 + 1e-9
    assert 0.5 - 1e-9 <= route.pose[step, 1] <= 0.7 + 1e-9


def test_visits_are_made_in_their_order(quick_config, vary, machine):
    """Two boxes, and the same two the other way around."""
    boxes = [{"box": {"y_m": [0.4, 0.6], "z_m": [0.6, 0.8]}}, {"box": {"y_m": [0.65, 0.8], "z_m": [0.3, 0.55]}}]
    for order in (boxes, boxes[::-1]):
        config = vary(quick_config, {"task.visit": order, "task.tilt_max_deg": 20})
        regions, route = _plan(config, machine)
        assert route.visits[route.visits > 0].tolist() == [1, 2]
        assert task_violations(config, regions, route.region, route.pose[:, 0]) == []


@pytest.mark.parametrize(
    ("budget", "least"),
    [({"mode_changes": 3}, 274.198822), ({"tilt_deg": 60}, 330.0), ({"travel_m": 2.0}, 274.198822)],
)
def test_budgets_are_kept(quick_config, vary, quick, assert_rules, budget, least):
    """Tighter ones cost more; what was used is added up from the route alone."""
    config = vary(quick_config, {"task.budget": budget})
    route = plan_route(config, quick.machine, quick.regions)
    assert_rules(config, quick.machine, route)
    assert route.objective >= least - 1e-6
    moved = np.abs(np.diff(route.pose, axis=0))
    used = {
        "mode_changes": route.mode_changes,
        "tilt_deg": np.rad2deg(moved[:, [3, 5]].sum()),
        "travel_m": moved[:, :3].sum(),
    }
    for key, limit in budget.items():
        assert used[key] <= limit + 1e-6


def test_a_budget_that_no_way_keeps_is_named(quick_config, vary, quick):
    """LLL to RRR takes three changes of working mode: two are proven too few."""
    config = vary(quick_config, {"task.budget.mode_changes": 2})
    with pytest.raises(NoSolutionError, match=r"uses at least 3 of task\.budget\.mode_changes \(proven\)") as caught:
        plan_route(config, quick.machine, quick.regions)
    assert caught.value.diagnosis["budget"] == "mode_changes"
    tilt = vary(quick_config, {"task.budget.tilt_deg": 10})
    with pytest.raises(NoSolutionError, match=r"at least \d+ of task\.budget\.tilt_deg"):
        plan_route(tilt, quick.machine, quick.regions)


def test_visits_that_cannot_be_are_told_before_any_search(quick_config, vary, machine):
    """Out of reach, a wrong sign of det H, or a box between the grid's points."""
    far = vary(quick_config, {"task.visit": [{"pose": {**POSE, "z_m": 5.0}}]})
    with pytest.raises(ConfigError, match=r"task\.visit\[0\]\.pose: is out of reach"):
        task_endpoints(far, machine)
    between = vary(quick_config, {"task.visit": [{"box": {"y_m": [0.61, 0.62], "z_m": [0.61, 0.62]}}]})
    with pytest.raises(NoSolutionError, match=r"no region of the grid lies in task\.visit\[0\]"):
        build_regions(between, machine)
    around = {"y_m": [0.5, 0.7], "z_m": [0.6, 0.8]}
    barred = vary(quick_config, {"task.visit": [{"box": around}], "task.avoid": [around]})
    with pytest.raises(NoSolutionError, match=r"(?s)in task\.visit\[0\].*route\.avoid_margin"):
        build_regions(barred, machine)
    inside = vary(quick_config, {"task.avoid": [{"y_m": [0.2, 0.4], "z_m": [0.8, 1.0]}]})
    with pytest.raises(ConfigError, match=r"task\.goal: is inside task\.avoid\[0\]"):
        task_endpoints(inside, machine)
    nowhere = vary(quick_config, {"task.visit": [{"pose": {**POSE, "mode": "LRL", "z_m": 1.0, "y_m": 0.3}}]})
    with pytest.raises(ConfigError, match=r"task\.visit"):
        task_endpoints(nowhere, machine)


def test_a_box_has_the_grid_points_on_its_sides(quick_config, vary, machine):
    """Rounding, as of 0.7000000000000001 on a grid, leaves out neither a row of the grid nor the end of a window."""
    box = {"y_m": [0.65, 0.7], "z_m": [0.55, 0.6]}
    regions = build_regions(vary(quick_config, {"task.visit": [{"box": box}], "task.tilt_max_deg": 0}), machine)
    visited = regions.controlled[regions.visits == 1]
    assert (np.abs(visited[:, 2] - 0.6) < 1e-9).any()
    assert 0.7 < visited[:, 1].max() < 0.7 + 1e-9
    least = float(regions.x_window_m[regions.visits == 1, 0].min())
    edge = {**box, "x_m": [least - 1.0, least - 1e-12]}
    regions = build_regions(vary(quick_config, {"task.visit": [{"box": edge}], "task.tilt_max_deg": 0}), machine)
    assert (regions.visits == 1).any()


def test_a_budget_may_be_used_up_exactly(vary, machine):
    """From x 1.3 to 1.0 takes 0.3 m, which is what is allowed, whatever 1.3 - 1.0 is in binary."""
    changes = {"task.start.x_m": 1.3, "task.goal.x_m": 1.0, "task.goal.mode": "LLL", "task.budget.travel_m": 0.3}
    config = vary(load_config(CONFIGS / "tiny.yaml"), changes)
    _, route = _plan(config, machine)
    np.testing.assert_allclose(route.pose[:, 1], 0.3)
