"""Routes on a grid of x."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.route.bounds.prices import priced_bounds
from pipeline.route.bounds.shortest_paths import shortest_paths
from pipeline.route.core.build import build_core
from pipeline.route.core.x_grid import route_on_grid
from pipeline.route.cost.actuator_time import ActuatorTime
from pipeline.route.cost.kappa_integral import KappaIntegral
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.cost.objectives import route_cost
from pipeline.route.problem import RouteProblem
from pipeline.route.search.optimum import prove_on_core
from pipeline.route.search.rule_check import rule_violations
from pipeline.route.search.states import unexpanded_graph

WIDE = np.array([1.0, 1e3, 1e3, 1e3, 1e3])
COSTS = [
    KappaSum(),
    KappaIntegral(np.array([1.0, 2.0, 1e3, 1e3, 1e3])),
    ActuatorTime(np.array([1.0, 0.5, 2.0, 0.3, 0.2]), 1.0),
]


@pytest.mark.parametrize("cost", COSTS, ids=lambda cost: type(cost).__name__)
@settings(max_examples=20)
@given(seed=st.integers(0, 1_000_000), shift=st.sampled_from([0.0, 0.3]), per_move=st.integers(1, 3))
def test_a_route_on_the_grid_keeps_the_rules_and_is_no_better_than_the_optimum(
    random_problem, quick_config, vary, machine, cost, seed, shift, per_move
):
    """Where x costs nothing and all windows end at whole steps it is the optimum; the goal may be off them."""
    regions, moves, positions = random_problem(seed)
    regions.x_window_m[regions.goal] += shift
    regions.controlled[regions.goal, 0] += shift
    random = np.random.default_rng(seed)
    regions.q_m[:] = random.uniform(-1.0, 1.0, regions.q_m.shape)
    regions.q_m[:, :3] += regions.controlled[:, :1]
    config = vary(quick_config, {"route.x_step_m": 1.0, "route.step_budget": positions})
    problem = replace(RouteProblem.of(config, machine, regions, moves), cost=cost)
    bounds = priced_bounds(regions, moves, cost, ())
    if not np.isfinite(bounds.optimum):
        return
    core = build_core(problem, regions, moves, bounds, positions * cost.most(regions))
    found = None if core.empty else route_on_grid(problem, core, regions, np.empty(0), per_move)
    best = prove_on_core(problem, unexpanded_graph(regions, moves), bounds)
    if found is None:
        assert best is None or shift or cost.counts_x
        return
    rows, x = found
    assert rule_violations(regions, rows, x, WIDE, positions) == []
    assert route_cost(cost, regions, rows, x) >= best.objective - 1e-6
    if not shift and not cost.counts_x:
        assert route_cost(cost, regions, rows, x) == pytest.approx(best.objective)


def test_a_search_of_too_many_states_is_left_out(small):
    """Ten million points per move: no time and memory are spent on them."""
    problem = RouteProblem.of(small.config, small.machine, small.regions, small.moves)
    bounds = shortest_paths(small.regions, small.moves, KappaSum())
    core = build_core(problem, small.regions, small.moves, bounds, 1.1 * bounds.optimum)
    assert route_on_grid(problem, core, small.regions, np.empty(0), 1) is not None
    assert route_on_grid(problem, core, small.regions, np.empty(0), 10_000_000) is None
