"""Routes whose travel along X costs: against a dynamic program on a grid of x, from above and from below."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.route.bounds.prices import priced_bounds
from pipeline.route.cost.actuator_time import ActuatorTime
from pipeline.route.cost.kappa_integral import KappaIntegral
from pipeline.route.cost.objectives import route_cost
from pipeline.route.problem import RouteProblem
from pipeline.route.search.optimum import prove_on_core
from pipeline.route.search.rule_check import rule_violations
from pipeline.route.search.states import unexpanded_graph

STEPS = np.array([1.0, 2.0, 1e3, 1e3, 1e3])
COSTS = [KappaIntegral(STEPS), ActuatorTime(np.array([1.0, 0.5, 2.0, 0.3, 0.2]), 1.0)]
SPACING = 0.05


def _least_on_grid(problem, slack):
    """Bellman's recursion over region and x on a grid: exact there with no slack, a lower bound for all x with it.

    An x off the grid is nearer than half a spacing to one on it, so that a travel changes by at most a spacing.
    """
    regions, moves = problem.regions, problem.moves
    low, high = regions.x_window_m.min(), regions.x_window_m.max()
    grid = np.arange(low, high + SPACING / 2.0, SPACING)
    rows = np.arange(len(regions))
    source, target = np.append(moves.source, rows), np.append(moves.target, rows)
    inside = (grid >= regions.x_window_m[:, :1] - slack / 2.0 - 1e-9) & (
        grid <= regions.x_window_m[:, 1:] + slack / 2.0 + 1e-9
    )
    most = round((1.0 + slack) / SPACING)
    to_go = np.full(inside.shape, np.inf)
    to_go[regions.goal, inside[regions.goal]] = 0.0
    for _ in range(problem.options.step_budget - 1):
        better = to_go.copy()
        for shift in range(-most, most + 1):
            dx = shift * SPACING
            around = np.linspace(dx - slack, dx + slack, 1 if slack == 0.0 else 9)
            # A convex cost is least between the points of a fine grid by no more than half its rise over one of them.
            at = np.array([problem.cost.at(regions, source, target, np.full(len(source), d)) for d in around])
            cost = at.min(axis=0) - (np.abs(np.diff(at, axis=0)).max(axis=0) if slack else 0.0)
            ahead = np.full((len(source), len(grid)), np.inf)
            here = slice(max(0, -shift), len(grid) - max(0, shift))
            there = slice(max(0, shift), len(grid) - max(0, -shift))
            ahead[:, here] = to_go[target][:, there] + cost[:, None]
            np.minimum.at(better, source, ahead)
        to_go = np.where(inside, better, np.inf)
    start = np.flatnonzero(inside[regions.start] & (np.abs(grid - regions.x_window_m[regions.start, 0]) < 1e-9))
    return float(to_go[regions.start, start[0]])


@pytest.mark.parametrize("cost", COSTS, ids=lambda cost: type(cost).__name__)
@settings(max_examples=15)
@given(seed=st.integers(0, 1_000_000))
def test_the_optimum_lies_between_two_dynamic_programs(random_problem, quick_config, vary, machine, cost, seed):
    """One allows the x of a grid alone, the other a little more than is allowed; the route keeps all rules."""
    regions, moves, positions = random_problem(seed)
    positions = min(positions, 5)
    random = np.random.default_rng(seed)
    regions.q_m[:] = random.uniform(-1.0, 1.0, regions.q_m.shape)
    regions.q_m[-2:, :3] += regions.x_window_m[-2:, :1]
    config = vary(quick_config, {"route.x_step_m": 1.0, "route.step_budget": positions})
    problem = replace(RouteProblem.of(config, machine, regions, moves), cost=cost, steps=STEPS)
    most = _least_on_grid(problem, 0.0)
    bounds = priced_bounds(regions, moves, cost, ())
    found = prove_on_core(problem, unexpanded_graph(regions, moves), bounds) if np.isfinite(bounds.optimum) else None
    if found is None:
        assert not np.isfinite(most)
        return
    assert _least_on_grid(problem, SPACING) - 1e-6 <= found.objective <= most + 1e-6
    assert bounds.optimum <= found.objective + 1e-6
    assert found.bound <= found.objective + 1e-9
    assert found.objective - found.bound <= 2e-7 * found.objective + 1e-9
    rows, x = found.sequence.region, found.sequence.x_m
    wide = np.array([1.0, 1e3, 1e3, 1e3, 1e3])
    assert rule_violations(regions, rows, x, wide, positions) == []
    assert route_cost(cost, regions, rows, x) == pytest.approx(found.objective, rel=1e-9)
