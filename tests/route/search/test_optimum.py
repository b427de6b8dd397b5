"""Proofs of the least sum over the admitted moves."""

import pytest

from pipeline.errors import NoSolutionError
from pipeline.progress import Monitor
from pipeline.route.bounds.shortest_paths import shortest_paths
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.problem import RouteProblem
from pipeline.route.search.optimum import find_optimum, prove_on_core
from pipeline.route.search.states import unexpanded_graph


def _prove(problem):
    graph = unexpanded_graph(problem.regions, problem.moves)
    return prove_on_core(problem, graph, shortest_paths(problem.regions, problem.moves, KappaSum()))


@pytest.mark.parametrize(
    ("start_m", "goal_m", "x_step_m", "binds"), [(1.3, 0.6, 0.05, True), (1.02, 1.02, 0.03, False)]
)
def test_the_optimum_over_real_regions_is_that_of_a_dynamic_program(
    quick_config, vary, pose_problem, cheapest, start_m, goal_m, x_step_m, binds
):
    """Labels of cost and reachable x over five thousand regions; where x binds, the shortest path is not enough."""
    values = {
        "task.start.x_m": start_m,
        "task.goal.x_m": goal_m,
        "route.x_step_m": x_step_m,
        "route.step_budget": 20,
        "task.tilt_max_deg": 10,
    }
    problem = pose_problem(vary(quick_config, values))
    bounds = shortest_paths(problem.regions, problem.moves, KappaSum())
    objective = _prove(RouteProblem.of(problem.config, problem.machine, problem.regions, problem.moves)).objective
    expected = cheapest(problem.regions, problem.moves, 20, x_step_m, cap=objective + 0.1)
    assert objective == pytest.approx(expected, abs=1e-6)
    assert (objective > bounds.optimum + 1.0) == binds


def test_an_optimum_above_its_threshold_is_not_a_proof(hand_table, hand_moves, quick_config, vary, machine):
    """All nodes of the core look cheap enough, but x only lets the two costly ones follow each other.

    With a threshold of 15 the program finds 24; the core of all routes of at most 24 then proves it.
    """
    a_cheap, a_dear, j, b_cheap, b_dear, start, goal = range(7)
    wide = (-20.0, 20.0)
    regions = hand_table(
        [(0.0, 0.0), (8.0, 8.0), wide, (4.0, 4.0), (8.0, 8.0), wide, wide], [1.0, 11.0, 1.0, 1.0, 11.0, 1.0, 1.0]
    )
    before, after = (a_cheap, a_dear), (b_cheap, b_dear)
    moves = hand_moves(
        [(start, a) for a in before] + [(a, j) for a in before] + [(j, b) for b in after] + [(b, goal) for b in after]
    )
    assert shortest_paths(regions, moves, KappaSum()).optimum == 4.0
    config = vary(quick_config, {"route.x_step_m": 1.0, "route.step_budget": 5, "route.threshold_margin": 2.75})
    seen = []
    monitor = Monitor(lambda text, part=None: seen.append(text))
    optimum = _prove(RouteProblem.of(config, machine, regions, moves, monitor))
    assert optimum.objective == pytest.approx(24.0)
    assert optimum.threshold == pytest.approx(24.0)
    assert [text.split()[-1] for text in seen if text.startswith("route: core")] == ["15.00", "24.00"]


def test_programs_that_would_not_fit_are_refused(small, vary):
    """Cores and programs over all regions are counted before they are built."""
    for formulation, what in (("core", "a core below"), ("paper", "the paper program of")):
        config = vary(
            small.config,
            {"route.memory_gb": 1e-5, "route.step_budget": 500, "route.formulation": formulation},
        )
        problem = RouteProblem.of(config, small.machine, small.regions, small.moves)
        graph = unexpanded_graph(problem.regions, problem.moves)
        with pytest.raises(NoSolutionError, match=rf"{what} .*route\.memory_gb allows 1e-05"):
            find_optimum(problem, graph, shortest_paths(problem.regions, problem.moves, KappaSum()))
