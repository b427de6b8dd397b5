"""The rules of a route, checked on what a solver returned."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.route.rules import route_cost, rule_violations

STEPS = np.array([0.1, 0.2, 0.2, 0.3, 0.3])


@pytest.fixture
def regions(hand_table):
    """Make four regions in a row and two ends; region 1 is a gate of arm 2, after which that arm is R."""
    table = hand_table([(0.0, 1.0)] * 4 + [(0.5, 0.5), (0.6, 0.6)], [3.0, 4.0, 5.0, 6.0, 7.0, 8.0])
    controlled = np.zeros((6, 5))
    controlled[:, 1] = [0.2, 0.4, 0.6, 5.0, 0.0, 0.8]
    gate = np.array([0, 2, 0, 0, 0, 0])
    mode = np.array([0, 0, 2, 0, 0, 2])
    return replace(table, controlled=controlled, gate=gate, mode=mode)


ROWS = [4, 0, 1, 2, 5]
X = [0.5, 0.5, 0.5, 0.5, 0.6]


def _violations(regions, rows=ROWS, x=X, budget=25):
    return rule_violations(regions, np.array(rows), np.array(x), STEPS, budget)


def test_a_route_that_keeps_all_rules_breaks_none(regions):
    """Steps exactly as long as allowed, a mode changed at its gate, x within its windows."""
    assert _violations(regions) == []
    assert route_cost(regions, np.array(ROWS)) == 7.0 + 3.0 + 4.0 + 5.0


def test_the_goal_costs_nothing_however_long_it_is_waited_in(regions):
    """(25)-(26): the summation stops once the goal is reached; waiting elsewhere costs."""
    assert route_cost(regions, np.array([*ROWS, 5, 5])) == 19.0
    assert route_cost(regions, np.array([4, 0, 0, 1, 2, 5])) == 22.0


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
        changed = regions.mode.copy()
        changed[[2, 5]] = mode
        assert _violations(replace(regions, mode=changed)) == [f"(38): arm {arm} changes after step 2"]


def test_opposite_signs_of_det_h_are_named(regions):
    """There is a singularity between such regions."""
    sign = regions.det_sign.copy()
    sign[[2, 5]] = -1.0
    assert _violations(replace(regions, det_sign=sign)) == ["det H changes sign after step 2"]


@pytest.mark.parametrize(("column", "number"), [(2, 15), (3, 16), (4, 17)])
def test_all_coordinates_are_looked_at(regions, column, number):
    """(15)-(17): z, rx and rz as well as x and y."""
    controlled = regions.controlled.copy()
    controlled[[2, 5], column] = 0.31
    found = _violations(replace(regions, controlled=controlled))
    assert found == [f"({number}): the move after step 2 is too long"]
