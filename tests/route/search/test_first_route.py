"""First routes: what is there when the time is up."""

from dataclasses import replace

from pipeline.route.bounds.prices import priced_bounds
from pipeline.route.deadline import Deadline
from pipeline.route.problem import RouteProblem
from pipeline.route.search.best_so_far import BestSoFar
from pipeline.route.search.first_route import offer_first_route
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


def test_moves_beside_a_refused_one_are_followed_with_it(small, pose_problem, vary):
    """What is in the way of a move is mostly in the way of others: one search of a path more serves them all."""
    posed = pose_problem(vary(small.config, {"route.objective": "integral"}))
    problem = RouteProblem.of(posed.config, posed.machine, posed.regions, posed.moves)
    bounds = priced_bounds(posed.regions, posed.moves, problem.cost, ())
    graph, asked = unexpanded_graph(posed.regions, posed.moves), []

    def refuse_one(core, moves, base):
        asked.append(core)
        refused = (moves.source == asked[0].source[0]) & (moves.target == asked[0].target[0])
        return moves.take(~refused) if refused.any() else moves

    offer_first_route(problem, graph, bounds, refuse_one, BestSoFar(graph, bounds, bounds.optimum))
    source, target = asked[0].source[0], asked[0].target[0]
    assert ((asked[1].source == source) | (asked[1].target == target)).all()
    assert not ((asked[1].source == source) & (asked[1].target == target)).any()
    assert len(asked[1]) > 1


class _EndsWhenAsked(Deadline):
    """Time is up for the search, and never for its programs."""

    @property
    def passed(self) -> bool:
        return True

    @property
    def left_s(self) -> float:
        return 60.0
