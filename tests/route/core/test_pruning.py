"""Pruning: what can belong to a route stays, and what labels know is said."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.route.bounds.budgets import Budget, Prices
from pipeline.route.bounds.shortest_paths import shortest_paths
from pipeline.route.core.pruning import prune
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.deadline import Deadline
from pipeline.route.search.label_setting import solve_labels

ENDLESS = Deadline.after(np.inf)


@pytest.fixture(scope="module")
def draw_core(random_problem, core_of):
    """Give a function that makes the core of all routes of a random problem with a budget of travel."""

    def draw(seed: int, travel_m: float):
        regions, moves, positions = random_problem(seed)
        budgets = (Budget("travel_m", travel_m, (1, 2), travels=True),)
        bounds = replace(shortest_paths(regions, moves, KappaSum()), prices=Prices(budgets, (0.0,)))
        return regions, core_of(regions, moves, bounds, 1000.0, positions, 1.0)

    return draw


DRAWN = {"seed": st.integers(0, 1_000_000), "travel_m": st.floats(1.0, 25.0), "price": st.floats(0.0, 3.0)}


@settings(max_examples=100)
@given(**DRAWN)
def test_the_cheapest_way_is_the_optimum_where_x_costs_nothing(draw_core, seed, travel_m, price):
    """Labels know all about x then: least cost, way and arcs are those of the optimum, or nothing is left."""
    regions, core = draw_core(seed, travel_m)
    if core.empty:
        return
    best = solve_labels(core, np.full(1, price), ENDLESS)
    pruned = prune(core, np.full(1, price), 1000.0)
    assert pruned.least == pytest.approx(best.outcome.objective)
    assert pruned.core.empty == (len(best.region) == 0)
    if pruned.core.empty:
        return
    arcs = set(zip(pruned.core.region[pruned.core.tail], pruned.core.region[pruned.core.head], strict=True))
    assert arcs.issuperset(zip(best.region[:-1], best.region[1:], strict=True))
    way, x = pruned.region, pruned.x_m
    assert regions.kappa[way[:-1]].sum() == pytest.approx(best.outcome.objective)
    low, high = regions.x_window_m[way].T
    assert ((x >= low - 1e-9) & (x <= high + 1e-9)).all()
    assert np.abs(np.diff(x)).max() <= 1.0 + 1e-9
    assert (pruned.core.region[0], pruned.core.region[-1]) == (regions.start, regions.goal)


@settings(max_examples=50)
@given(**DRAWN, factor=st.floats(0.9, 1.5))
def test_a_lower_cost_leaves_less_and_the_optimum_last(draw_core, seed, travel_m, price, factor):
    """Just below the optimum nothing is left; what is pruned once is pruned for good."""
    _, core = draw_core(seed, travel_m)
    if core.empty:
        return
    best = solve_labels(core, np.full(1, price), ENDLESS).outcome.objective
    if not np.isfinite(best):
        return
    left = prune(core, np.full(1, price), factor * best).core
    assert left.empty == (factor < 1.0 - 1e-8)
    if not left.empty:
        again = prune(left, np.full(1, price), factor * best)
        assert again.least == pytest.approx(best)
        assert len(again.core.tail) <= len(left.tail)


@settings(max_examples=50)
@given(**DRAWN)
def test_the_way_back_is_pruned_alike(draw_core, seed, travel_m, price):
    """The core reversed has the same routes, and the core reversed twice is the core."""
    _, core = draw_core(seed, travel_m)
    if core.empty:
        return
    back = core.reversed
    for name in ("step", "region", "window_m", "tail", "head", "reach_m"):
        np.testing.assert_array_equal(getattr(back.reversed, name), getattr(core, name))
    there, here = (prune(each, np.full(1, price), 1000.0) for each in (back, core))
    assert there.least == pytest.approx(here.least)
    assert len(there.core.tail) == len(here.core.tail)
