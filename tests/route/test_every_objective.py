"""What a task may ask for, with every objective: visits, budgets, boxes, locked axes, alternatives, reasons."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.choices import RouteObjective
from pipeline.errors import InfeasibleError
from pipeline.route import Route, plan_route, plan_routes
from pipeline.route.bounds.bottleneck import moves_within
from pipeline.route.diagnosis.search import explain_infeasibility
from pipeline.route.metric import step_sizes
from pipeline.route.planner import solve_problem
from pipeline.route.problem import RouteProblem
from pipeline.route.search.rule_check import task_violations
from pipeline.route.search.states import near_route
from pipeline.status import Status
from tests.route.conftest import Problem

every = pytest.mark.parametrize("objective", list(RouteObjective))
ASKED = {
    "visits": {
        "task.visit": [
            {"box": {"y_m": [0.65, 0.8], "z_m": [0.55, 0.75]}, "modes": ["LLL", "LLR"]},
            {"box": {"rx_deg": [5, 10]}},
        ]
    },
    "modes": {"task.budget.mode_changes": 3},
    "tilt": {"task.budget.tilt_deg": 40.0},
    "travel": {"task.budget.travel_m": 1.4},
    "box": {"task.avoid": [{"y_m": [0.62, 0.66], "z_m": [0.0, 0.66]}]},
    "locked": {"task.locked_axes": ["rx"], "task.tilt_max_deg": 20},
    "along x": {"task.start.x_m": 1.3, "task.goal.x_m": 0.9},
}


@dataclass(frozen=True)
class Tasks:
    """Problems and their routes, each made once."""

    pose: Callable[[Config], Problem]
    vary: Callable[..., Config]
    small: Problem
    posed: dict[str, Problem]
    routes: dict[str, Route]

    def route(self, objective: RouteObjective, asked: str = "") -> tuple[Problem, Route]:
        """Plan for an objective and an entry of `ASKED`, or nothing more."""
        if asked not in self.posed:
            self.posed[asked] = self.pose(self.vary(self.small.config, ASKED[asked])) if asked else self.small
        config = self.vary(self.posed[asked].config, {"route.objective": objective.value})
        posed, key = replace(self.posed[asked], config=config), f"{objective} {asked}"
        if key not in self.routes:
            self.routes[key] = solve_problem(_of(posed))[0]
        return posed, self.routes[key]


def _of(posed: Problem) -> RouteProblem:
    return RouteProblem.of(posed.config, posed.machine, posed.regions, posed.moves)


@pytest.fixture(scope="module")
def tasks(pose_problem, small, vary) -> Tasks:
    """Make variants of the small problem."""
    return Tasks(pose_problem, vary, small, {}, {})


def _first(route: Route) -> tuple[float, float]:
    """Give what is compared: the largest kappa comes before the sum where it counts."""
    return route.kappa_max if route.objective_kind == RouteObjective.BOTTLENECK else 0.0, route.objective


@every
@pytest.mark.parametrize("asked", ASKED)
def test_all_that_is_asked_is_done_and_costs_no_less(tasks, assert_rules, objective, asked):
    """Proven optimal, and all rules kept; what leaves ends and limits as they are only takes routes away."""
    posed, route = tasks.route(objective, asked)
    assert route.status is Status.OPTIMAL
    assert_rules(posed.config, posed.machine, route)
    assert task_violations(posed.config, posed.regions, route.region, route.pose[:, 0]) == []
    if asked not in ("along x", "locked"):
        free = tasks.route(objective)[1]
        assert _first(route) >= (_first(free)[0] - 1e-9, 0.0)
        assert objective == RouteObjective.BOTTLENECK or route.objective >= free.objective - 1e-6
    if asked == "visits":
        assert [visit for visit in route.visits.tolist() if visit] == [1, 2]


@every
@pytest.mark.parametrize("asked", ["", "along x"])
def test_the_way_back_costs_the_same(tasks, objective, asked):
    """Start and goal exchanged; the sum counts kappa of the one and not of the other, and is told apart by it."""
    posed, route = tasks.route(objective, asked)
    task = posed.config.task.model_dump(mode="json")
    config = tasks.vary(posed.config, {"task.start": task["goal"], "task.goal": task["start"]})
    swapped = np.append(np.arange(len(posed.regions) - 2), [posed.regions.goal, posed.regions.start])
    back = plan_route(config, posed.machine, posed.regions.take(swapped))
    assert back.status is route.status is Status.OPTIMAL
    if objective in (RouteObjective.SUM, RouteObjective.BOTTLENECK):
        assert back.kappa_max == pytest.approx(route.kappa_max) or objective == RouteObjective.SUM
        assert back.objective + back.kappa[-1] == pytest.approx(route.objective + route.kappa[-1], rel=1e-7)
    else:
        assert back.objective == pytest.approx(route.objective, rel=1e-6)


@every
def test_alternatives_stray_and_are_in_the_order_of_their_cost(tasks, assert_rules, objective):
    """Each leaves the neighbourhood of every better one somewhere."""
    posed, best = tasks.route(objective)
    found = plan_routes(posed.config, posed.machine, posed.regions, 3)
    assert _first(found[0]) == pytest.approx(_first(best), rel=1e-6)
    distance, steps = posed.config.route.alternative_distance, step_sizes(posed.config.route)
    for better, worse in pairwise(found):
        assert _first(better) <= tuple(value * (1.0 + 1e-6) for value in _first(worse))
    for rank, route in enumerate(found):
        assert route.status is Status.OPTIMAL
        assert_rules(posed.config, posed.machine, route)
        for better in found[:rank]:
            near = near_route(posed.regions, steps, better.region, distance)
            assert not near[route.region].all()


@every
def test_too_small_a_budget_is_proven_and_the_least_that_does_is_named(tasks, vary, objective):
    """Three arms change their mode: two changes are refused, three are advised, whatever is minimised."""
    posed, _ = tasks.route(objective)
    config = vary(posed.config, {"task.budget.mode_changes": 2})
    with pytest.raises(InfeasibleError, match=r"at least 3 of task\.budget\.mode_changes \(proven\)"):
        plan_route(config, posed.machine, posed.regions)
    found = explain_infeasibility(config, posed.machine, posed.regions, limits=[])
    assert "set task.budget.mode_changes to 3" in found.advice


@every
def test_a_route_under_the_least_largest_kappa_is_no_better(tasks, objective):
    """A cap on kappa takes routes away; under the least there is, every objective has the same largest kappa."""
    posed, route = tasks.route(objective)
    least = tasks.route(RouteObjective.BOTTLENECK)[1].kappa_max
    moves = moves_within(posed.moves, posed.regions.kappa, least)
    capped = solve_problem(_of(replace(posed, moves=moves)))[0]
    assert capped.kappa_max == pytest.approx(least)
    assert capped.objective >= route.objective - 1e-6
    assert np.isfinite(capped.search.bound)
