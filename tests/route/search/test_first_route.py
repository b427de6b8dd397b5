"""First routes: what is there when the time is up."""

from dataclasses import replace

from pipeline.route.bounds.prices import priced_bounds
from pipeline.route.deadline import Deadline
from pipeline.route.problem import RouteProblem
from pipeline.route.search.optimum import prove_on_core
from pipeline.route.search.states import unexpanded_graph


def test_a_route_found_in_time_is_kept_with_its_gap(small, pose_problem, vary):
    """The clock stops the search once the first route is there: not proven, and the bound says how far off."""
    config = vary(small.config, {"route.objective": "integral", "task.start.x_m": 1.3, "task.goal.x_m": 0.9})
    posed = pose_problem(config)
    problem = RouteProblem.of(config, posed.machine, posed.regions, posed.moves)
    bounds = priced_bounds(posed.regions, posed.moves, problem.cost, ())
    graph = unexpanded_graph(posed.regions, posed.moves)
    best = prove_on_core(problem, graph, bounds)
    found = prove_on_core(replace(problem, deadline=_EndsWhenAsked(1.0, 0.0)), graph, bounds)
    assert best.proven
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
