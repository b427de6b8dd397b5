"""Shortest paths: bounds for every region, and the optima that others computed, too."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.route.bounds.budgets import Budget, Prices
from pipeline.route.bounds.shortest_paths import fewest_positions, least_use, shortest_paths, shortest_route
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.moves.candidates import find_moves


def _bellman(regions, moves, source, target, root, weight):
    """Relax all moves until nothing changes: costs from `root` along source -> target."""
    cost = np.full(len(regions), np.inf)
    cost[root] = 0.0
    while True:
        before = cost.copy()
        np.minimum.at(cost, target, cost[source] + weight)
        if (cost == before).all():
            return cost


def test_optimum_and_fewest_positions_agree_with_an_independent_implementation(cross):
    """LLL to RRR, 0.1 m, 10 degrees: 274.198823 (to six decimals 274.198822 here), twelve positions at least."""
    bounds = shortest_paths(cross.regions, cross.moves, KappaSum())
    assert bounds.optimum == pytest.approx(274.198822, abs=1e-6)
    assert fewest_positions(cross.regions, cross.moves) == 12
    route = shortest_route(cross.regions, cross.moves, KappaSum(), bounds)
    assert cross.regions.kappa[route].max() == pytest.approx(33.999, abs=1e-3)


def test_reversed_task_costs_the_same_but_for_the_ends(cross, vary):
    """All-right to all-left: 273.460101; start and goal change places, and only the start's kappa counts."""
    swapped = np.arange(len(cross.regions))
    swapped[-2:] = cross.regions.goal, cross.regions.start
    regions = cross.regions.take(swapped)
    moves = find_moves(cross.config, cross.machine, regions)
    backwards = shortest_paths(regions, moves, KappaSum()).optimum
    assert backwards == pytest.approx(273.460101, abs=1e-6)
    forwards = shortest_paths(cross.regions, cross.moves, KappaSum()).optimum
    ends = cross.regions.kappa[[cross.regions.start, cross.regions.goal]]
    assert forwards - backwards == pytest.approx(ends[0] - ends[1], abs=1e-9)


@pytest.mark.parametrize(
    ("key", "value", "optimum"),
    [
        ("task.tilt_max_deg", 0, np.inf),
        ("task.tilt_max_deg", 5, np.inf),
        ("task.tilt_max_deg", 10, 364.992),
        ("task.tilt_max_deg", 20, 311.625),
        ("task.locked_axes", ["rx"], 338.896),
        ("task.locked_axes", ["rz"], 412.190),
        ("task.locked_axes", ["rx", "rz"], np.inf),
    ],
)
def test_tilt_is_what_makes_a_route_possible(cross_config, vary, pose_problem, key, value, optimum):
    """None with little or no tilt, and the known optima with more, or with one axis locked."""
    problem = pose_problem(vary(cross_config, {key: value}))
    assert shortest_paths(problem.regions, problem.moves, KappaSum()).optimum == pytest.approx(optimum, abs=1e-3)


def test_bounds_are_what_bellmans_recursion_gives(small):
    """F from the start and B to the goal, for every region."""
    regions, moves = small.regions, small.moves
    bounds = shortest_paths(regions, moves, KappaSum())
    weight = regions.kappa[moves.source]
    forward = _bellman(regions, moves, moves.source, moves.target, regions.start, weight)
    backward = _bellman(regions, moves, moves.target, moves.source, regions.goal, weight)
    np.testing.assert_allclose(bounds.forward, forward)
    np.testing.assert_allclose(bounds.backward, backward)
    assert 0 < np.isfinite(forward).sum() < len(regions)


@given(st.integers(0, 100_000))
def test_no_region_is_on_a_route_cheaper_than_the_optimum(random_problem, seed):
    """F + B is the optimum along a shortest path and nowhere less; F leaves out what B counts."""
    regions, moves, _ = random_problem(seed)
    bounds = shortest_paths(regions, moves, KappaSum())
    through = bounds.forward + bounds.backward
    assert bounds.forward[regions.start] == bounds.backward[regions.goal] == 0.0
    assert bounds.forward[regions.goal] == bounds.optimum
    if not np.isfinite(bounds.optimum):
        assert fewest_positions(regions, moves) is None
        return
    assert through.min() >= bounds.optimum - 1e-9
    route = shortest_route(regions, moves, KappaSum(), bounds)
    assert (route[0], route[-1]) == (regions.start, regions.goal)
    pairs = set(zip(moves.source.tolist(), moves.target.tolist(), strict=True))
    assert all(pair in pairs for pair in zip(route.tolist(), route[1:].tolist(), strict=False))
    assert regions.kappa[route[:-1]].sum() == pytest.approx(bounds.optimum)
    np.testing.assert_allclose(through[route], bounds.optimum)
    assert fewest_positions(regions, moves) <= len(route)


def test_fewest_positions_do_not_depend_on_costs(hand_table, hand_moves):
    """Two costly moves are fewer than three cheap ones."""
    regions = hand_table([(0.0, 0.0)] * 5, [1.0, 1.0, 100.0, 1.0, 1.0])
    moves = hand_moves([(3, 0), (0, 1), (1, 4), (3, 2), (2, 4)])
    assert fewest_positions(regions, moves) == 3
    bounds = shortest_paths(regions, moves, KappaSum())
    assert bounds.optimum == 3.0
    assert shortest_route(regions, moves, KappaSum(), bounds).tolist() == [3, 0, 1, 4]


@given(st.integers(0, 100_000))
def test_fewest_positions_are_those_of_a_search_step_by_step(random_problem, seed):
    """Regions reached after one move, two moves and so on; none after all regions means never."""
    regions, moves, _ = random_problem(seed)
    pairs = set(zip(moves.source.tolist(), moves.target.tolist(), strict=True))
    reached, positions = {regions.start}, 1
    while regions.goal not in reached and positions <= len(regions):
        reached, positions = reached | {j for i, j in pairs if i in reached}, positions + 1
    assert fewest_positions(regions, moves) == (positions if regions.goal in reached else None)


def test_prices_and_use_of_budgets_are_added_move_by_move(small):
    """Against Bellman's recursion, with blocks so small that there are many."""
    regions, moves = small.regions, small.moves
    budget = Budget("travel_m", 3.0, (1, 2), travels=True)
    used = budget.used(regions, moves.source, moves.target)
    assert used.max() > 0.1
    bounds = shortest_paths(regions, moves, KappaSum(), Prices((budget,), (7.0,)), block_size=1_000)
    weight = regions.kappa[moves.source] + 7.0 * used
    forward = _bellman(regions, moves, moves.source, moves.target, regions.start, weight)
    backward = _bellman(regions, moves, moves.target, moves.source, regions.goal, weight)
    np.testing.assert_allclose(bounds.forward, forward)
    np.testing.assert_allclose(bounds.backward, backward)
    least = _bellman(regions, moves, moves.source, moves.target, regions.start, used)[regions.goal]
    assert least_use(regions, moves, budget, block_size=1_000) == pytest.approx(least)
