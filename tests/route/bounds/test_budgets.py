"""Budgets: what moves use of them, and what they cost at a price."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.route import RegionTable
from pipeline.route.bounds.budgets import FREE, Prices, task_budgets
from pipeline.route.cost.kappa_sum import KappaSum


@pytest.fixture
def regions(hand_table) -> RegionTable:
    """Make two regions and two ends; from the first to the second y, z, rx, rz and two arms' modes change."""
    table = hand_table([(0.0, 1.0), (0.0, 1.0), (0.2, 0.2), (0.5, 0.5)], [2.0, 3.0, 4.0, 5.0])
    controlled = np.zeros((4, 5))
    controlled[1] = [0.0, 0.1, -0.2, 0.3, -0.4]
    return replace(table, controlled=controlled, modes=np.array([0, 5, 0, 0]))


@pytest.fixture
def budgets(quick_config, vary):
    """Read a budget of each kind."""
    return task_budgets(vary(quick_config, {"task.budget": {"mode_changes": 4, "tilt_deg": 90.0, "travel_m": 2.0}}))


def test_a_move_uses_the_sum_of_its_absolute_changes(regions, budgets):
    """Changes of working mode per arm, of rx and rz, of y and z; x is left out, and staying uses nothing."""
    used = {budget.key: budget.used(regions, np.array([0, 1, 0]), np.array([1, 0, 0])).tolist() for budget in budgets}
    assert used["mode_changes"] == [2.0, 2.0, 0.0]
    assert used["tilt_deg"] == pytest.approx([0.7, 0.7, 0.0])
    assert used["travel_m"] == pytest.approx([0.3, 0.3, 0.0])


def test_the_way_along_x_is_taken_off_what_is_left(regions, budgets):
    """Only where travel along X counts; it is added again to what is shown, in the unit of the key."""
    left = {budget.key: budget.left(regions) for budget in budgets}
    assert left == pytest.approx({"mode_changes": 4.0, "tilt_deg": np.pi / 2.0, "travel_m": 1.7})
    shown = {budget.key: budget.shown(regions, 1.0) for budget in budgets}
    assert shown == {"mode_changes": "1", "tilt_deg": "57.2957", "travel_m": "1.3"}


def test_a_price_is_paid_per_use_and_credited_for_all_that_is_left(regions, budgets):
    """Lagrange multipliers; without any there is nothing to pay."""
    prices = Prices(budgets, (10.0, 0.0, 100.0))
    penalty = prices.penalty(regions, np.array([0]), np.array([1]))
    assert penalty.tolist() == pytest.approx([10.0 * 2.0 + 100.0 * 0.3])
    assert prices.credit(KappaSum(), regions) == pytest.approx(10.0 * 4.0 + 100.0 * 1.7)
    assert prices.charged
    assert not FREE.charged
    assert FREE.credit(KappaSum(), regions) == 0.0


def test_what_is_not_limited_is_not_a_budget(quick_config):
    """quick.yaml limits nothing."""
    assert task_budgets(quick_config) == ()
