"""The rules of a route, checked on what a solver returned."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.route.search.rule_check import rule_violations, task_violations

STEPS = np.array([0.1, 0.2, 0.2, 0.3, 0.3])


@pytest.fixture
def regions(hand_table):
    """Make four regions in a row and two ends; region 1 is a gate of arm 2, after which that arm is R."""
    table = hand_table([(0.0, 1.0)] * 4 + [(0.5, 0.5), (0.6, 0.6)], [3.0, 4.0, 5.0, 6.0, 7.0, 8.0])
    controlled = np.zeros((6, 5))
    controlled[:, 1] = [0.2, 0.4, 0.6, 5.0, 0.0, 0.8]
    gate = np.array([0, 2, 0, 0, 0, 0])
    mode = np.array([0, 0, 2, 0, 0, 2])
    return replace(table, controlled=controlled, gates=gate, modes=mode)


ROWS = [4, 0, 1, 2, 5]
X = [0.5, 0.5, 0.5, 0.5, 0.6]


def _violations(regions, rows=ROWS, x=X, budget=25):
    return rule_violations(regions, np.array(rows), np.array(x), STEPS, budget)


def test_a_route_that_keeps_all_rules_breaks_none(regions):
    """Steps exactly as long as allowed, a mode changed at its gate, x within its windows."""
    assert _violations(regions) == []


@pytest.mark.parametrize(
    ("rows", "x", "budget", "broken"),
    [
        (ROWS[1:], X[1:], 25, ["(8)-(9)"]),
        (ROWS[:-1], X[:-1], 25, ["(10)-(11)"]),
        (ROWS, X, 4, ["step budget"]),
        (ROWS, [0.5, 0.5, 0.5, 0.5, 0.600001], 25, ["(18): x of step 4", "(13): the move after step 3"]),
        (ROWS, [0.5, 0.5, 0.55, 0.45, 0.6], 25, ["(13): the move after step 3"]),
        ([4, 1, 2, 5], [0.5, 0.5, 0.5, 0.6], 25, ["(14): the move after step 0"]),
        ([4, 0, 2, 5], [0.5, 0.5, 0.5, 0.6], 25, ["(14): the move after step 1", "(38): arm 2 changes after step 1"]),
    ],
)
def test_every_broken_rule_is_named_with_its_step(regions, rows, x, budget, broken):
    """By the number of its equation in the paper."""
    found = _violations(regions, rows, x, budget)
    assert len(found) == len(broken)
    assert all(any(part in text for text in found) for part in broken)


def test_a_mode_may_change_only_for_the_arm_of_the_gate(regions):
    """Region 1 is a gate of arm 2: neither arm 1 nor arm 3 changes there."""
    for mode, arm in ((4, 1), (1, 3)):
        changed = regions.modes.copy()
        changed[[2, 5]] = mode
        assert _violations(replace(regions, modes=changed)) == [f"(38): arm {arm} changes after step 2"]


def test_opposite_signs_of_det_h_are_named(regions):
    """There is a singularity between such regions."""
    sign = regions.det_sign.copy()
    sign[[2, 5]] = -1.0
    assert _violations(replace(regions, det_sign=sign)) == ["det H changes sign after step 2"]


@pytest.mark.parametrize(("column", "number"), [(2, 15), (3, 16), (4, 17)])
def test_all_coordinates_are_checked(regions, column, number):
    """(15)-(17): z, rx and rz as well as x and y."""
    controlled = regions.controlled.copy()
    controlled[[2, 5], column] = 0.31
    found = _violations(replace(regions, controlled=controlled))
    assert found == [f"({number}): the move after step 2 is too long"]


@pytest.mark.parametrize(
    ("changes", "broken"),
    [
        ({"task.tilt_max_deg": 10}, []),
        ({"task.tilt_max_deg": 9}, ["task.tilt_max_deg: rx of step 2 is beyond it"]),
        ({"task.locked_axes": ["rz"]}, []),
        ({"task.locked_axes": ["rx"]}, ["task.locked_axes: rx of step 2 is beyond it"]),
    ],
)
def test_tilt_limits_and_locked_axes_are_checked(quick_config, vary, regions, changes, broken):
    """A tilt of 10 degrees at one step: within the limit of 10, beyond 9, and none about a locked axis."""
    controlled = regions.controlled.copy()
    controlled[1, 3] = np.deg2rad(-10.0)
    tilted = replace(regions, controlled=controlled)
    assert task_violations(vary(quick_config, changes), tilted, np.array(ROWS), np.array(X)) == broken


def _asked(vary, quick_config, regions, task, rows=ROWS, x=X):
    config = vary(quick_config, {f"task.{key}": value for key, value in task.items()} | {"route.avoid_margin": 0.0})
    return task_violations(config, regions, np.array(rows), np.array(x))


ANYWHERE = {"box": {"x_m": [-9, 9]}}


@pytest.mark.parametrize(
    ("stops", "missed"),
    [
        ([1, 2, 0, 0], []),
        ([2, 1, 2, 0], []),
        ([1, 1, 2, 0], []),
        ([2, 1, 0, 0], [1]),
        ([0, 2, 2, 0], [0, 1]),
        ([0, 0, 1, 0], [1]),
        ([0, 0, 0, 1], [0, 1]),
    ],
)
def test_visits_not_made_in_their_turn_are_named(vary, quick_config, regions, stops, missed):
    """One that comes before its turn does not count; passing by again does no harm. Region 3 is not on the route."""
    table = replace(regions, visits=np.array([*stops, 0, 0]))
    found = _asked(vary, quick_config, table, {"visit": [ANYWHERE, ANYWHERE]})
    assert found == [f"task.visit[{k}] is not visited in its turn" for k in missed]


@pytest.mark.parametrize(
    ("key", "used"),
    [("mode_changes", 1), ("tilt_deg", np.rad2deg(0.2 + 0.3)), ("travel_m", 0.1 + 0.8 + 0.25)],
)
def test_a_budget_that_is_exceeded_is_named(vary, quick_config, regions, key, used):
    """By what was used and what is allowed: x counts from step to step, y and z and both tilts as they are."""
    controlled = regions.controlled.copy()
    controlled[0, 3:] = [0.1, -0.15]
    controlled[1, 2] = 0.125
    table = replace(regions, controlled=controlled)
    limit = used if key == "mode_changes" else round(float(used), 3) + 0.001
    assert _asked(vary, quick_config, table, {"budget": {key: limit}}) == []
    less = 0 if key == "mode_changes" else limit - 0.002
    assert _asked(vary, quick_config, table, {"budget": {key: less}}) == [
        f"task.budget.{key}: {used:g} used, {less:g} allowed"
    ]
    assert _asked(vary, quick_config, table, {"budget": dict.fromkeys(("mode_changes", "tilt_deg", "travel_m"))}) == []


@pytest.mark.parametrize(
    ("box", "steps"),
    [
        ({"y_m": [0.45, 0.55]}, [2]),
        ({"y_m": [0.35, 0.45]}, [1, 2]),
        ({"y_m": [0.4, 0.6]}, [2]),
        ({"y_m": [0.45, 0.55], "x_m": [0.0, 0.5]}, []),
        ({"y_m": [0.65, 0.75], "x_m": [0.53, 0.57]}, [3]),
        ({"y_m": [0.45, 0.55], "rz_deg": [-1.0, 1.0]}, [2]),
        ({"y_m": [0.45, 0.55], "rz_deg": [1.0, 2.0]}, []),
        ({"y_m": [0.9, 1.0]}, []),
    ],
)
def test_a_box_that_is_entered_is_named_with_the_move(vary, quick_config, regions, box, steps):
    """Between two steps outside it, too; along its surface is not inside."""
    far = {"y_m": [5.0, 6.0]}
    found = _asked(vary, quick_config, regions, {"avoid": [far, box]})
    assert found == [f"task.avoid[1] is entered after step {step}" for step in steps]
