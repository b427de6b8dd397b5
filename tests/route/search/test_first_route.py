"""First routes: they keep all rules, and cost no less than the optimum."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.route.bounds.budgets import task_budgets
from pipeline.route.bounds.prices import priced_bounds
from pipeline.route.cost.actuator_time import ActuatorTime
from pipeline.route.cost.kappa_integral import KappaIntegral
from pipeline.route.cost.objectives import route_cost
from pipeline.route.deadline import Deadline
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.core import build_core
from pipeline.route.search.beam import beam_route
from pipeline.route.search.optimum import prove_on_core
from pipeline.route.search.rule_check import rule_violations, task_violations
from pipeline.route.search.states import unexpanded_graph

STEPS = np.array([1.0, 2.0, 1e3, 1e3, 1e3])
WIDE = np.array([1.0, 1e3, 1e3, 1e3, 1e3])
COSTS = [KappaIntegral(STEPS), ActuatorTime(np.array([1.0, 0.5, 2.0, 0.3, 0.2]), 1.0)]


@pytest.mark.parametrize("cost", COSTS, ids=lambda cost: type(cost).__name__)
@settings(max_examples=15)
@given(seed=st.integers(0, 1_000_000), travel_m=st.one_of(st.none(), st.floats(4.0, 30.0)))
def test_a_beam_keeps_the_rules_and_is_no_better_than_the_optimum(
    random_problem, quick_config, vary, machine, cost, seed, travel_m
):
    """With and without a budget of travel; the optimum is not missed either where it finds a route."""
    regions, moves, positions = random_problem(seed)
    random = np.random.default_rng(seed)
    regions.q_m[:] = random.uniform(-1.0, 1.0, regions.q_m.shape)
    regions.q_m[:, :3] += regions.controlled[:, :1]
    config = vary(
        quick_config,
        {"route.x_step_m": 1.0, "route.step_budget": positions, "task.budget.travel_m": travel_m},
    )
    problem = replace(RouteProblem.of(config, machine, regions, moves), cost=cost, steps=STEPS)
    bounds = priced_bounds(regions, moves, cost, task_budgets(config))
    if not np.isfinite(bounds.optimum):
        return
    core = build_core(problem, regions, moves, bounds, positions * cost.most(regions))
    route = None if core.empty else beam_route(problem, core, bounds, regions)
    found = prove_on_core(problem, unexpanded_graph(regions, moves), bounds)
    if found is not None:
        assert task_violations(config, regions, found.sequence.region, found.sequence.x_m) == []
    if route is None:
        return
    rows, x = route
    assert rule_violations(regions, rows, x, WIDE, positions) == []
    assert task_violations(config, regions, rows, x) == []
    assert found.objective <= route_cost(cost, regions, rows, x) + 1e-6


def test_a_route_found_in_time_is_kept_with_its_gap(small, vary):
    """The clock stops the search once the first routes are there: not proven, and the bound says how far off."""
    config = vary(small.config, {"route.objective": "integral"})
    problem = RouteProblem.of(config, small.machine, small.regions, small.moves)
    bounds = priced_bounds(small.regions, small.moves, problem.cost, ())
    graph = unexpanded_graph(small.regions, small.moves)
    best = prove_on_core(problem, graph, bounds)
    late = replace(problem, deadline=_EndsWhenAsked(1.0, 0.0))
    found = prove_on_core(late, graph, bounds)
    assert not found.proven
    assert found.bound <= best.objective + 1e-6
    assert found.objective >= best.objective - 1e-6


class _EndsWhenAsked(Deadline):
    """Time is up for the search, and never for its programs."""

    @property
    def passed(self) -> bool:
        return True

    @property
    def left_s(self) -> float:
        return 60.0
