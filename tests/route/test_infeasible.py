"""Proofs that there is no route."""

import numpy as np
import pytest

from pipeline.errors import InfeasibleError
from pipeline.limits import node_limits
from pipeline.route.bounds.shortest_paths import shortest_paths
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.infeasible import require_route, restrictions, without_route
from pipeline.route.moves.rejections import Rejection
from pipeline.route.moves.screen import Screen
from pipeline.route.problem import RouteProblem
from pipeline.route.search.states import unexpanded_graph

KAPPA = Rejection("kappa exceeds its cap", "route.kappa_max")
TILT = Rejection("the platform tilts too far", "task.tilt_max_deg")


@pytest.fixture
def posed(hand_table, hand_moves, quick_config, vary, machine):
    """Give a function that poses a chain of three moves, a metre of y each, with changed keys; and its graph."""

    def pose(values, pairs=((2, 0), (0, 1), (1, 3))):
        regions = hand_table([(0.0, 9.0), (0.0, 9.0), (0.0, 0.0), (0.5, 0.5)], [2.0, 3.0, 4.0, 5.0])
        regions.controlled[:, 1] = [1.0, 2.0, 0.0, 3.0]
        problem = RouteProblem.of(vary(quick_config, values), machine, regions, hand_moves(pairs))
        graph = unexpanded_graph(regions, problem.moves)
        return problem, graph, shortest_paths(regions, problem.moves, KappaSum())

    return pose


def test_what_the_graph_allows_is_not_refused(posed):
    """Four positions, three metres along y and half a metre along x."""
    require_route(*posed({"route.step_budget": 4, "task.budget.travel_m": 3.5}))


@pytest.mark.parametrize(
    ("values", "pairs", "reason", "advice", "facts"),
    [
        (
            {},
            [(2, 0), (1, 3)],
            "the start 2 of them can be reached over 2 admitted moves",
            "task.tilt_max_deg",
            "reached",
        ),
        (
            {"route.step_budget": 3},
            None,
            "at least 4 positions",
            "4 is a lower bound, and may not be enough",
            "fewest_positions",
        ),
        (
            {"task.budget.travel_m": 3.4},
            None,
            r"at least 3.5 of task\.budget\.travel_m",
            "3.5 is a lower bound, and may not be enough",
            "budget",
        ),
    ],
)
def test_what_the_graph_excludes_is_refused_with_the_key(posed, values, pairs, reason, advice, facts):
    """The goal out of reach, too few positions, a budget too small: all are proofs."""
    problem, graph, bounds = posed(values, pairs) if pairs else posed(values)
    with pytest.raises(InfeasibleError, match=reason) as caught:
        require_route(problem, graph, bounds)
    assert advice in caught.value.advice
    assert caught.value.diagnosis["status"] == "infeasible"
    assert facts in caught.value.diagnosis


def test_the_keys_most_moves_failed_on_come_first(posed):
    """Then the budgets of the task, the step budget and travel along X, and all else that restricts the task."""
    flaws = [TILT, KAPPA, TILT]
    screen = Screen(lambda source, target: flaws, 4)
    problem, graph, _ = posed({"task.budget.tilt_deg": 30.0})
    screen.screen(problem.moves, problem.moves, np.arange(4))
    error = without_route(problem, graph, screen)
    keys = ["task.tilt_max_deg", "route.kappa_max", "task.budget.tilt_deg", "route.step_budget", "route.x_step_m"]
    assert error.advice.startswith(f"let one or more of {', '.join(keys)}, machine.clearance.link_link_m, ")
    assert "task.avoid" not in error.advice
    assert error.advice.endswith("was not tried")
    assert "after 3 moves were forbidden" in error.reason


def test_nothing_has_two_names(quick_config, machine):
    """What moves fail on and what restricts a task are named alike, so that advice names nothing twice."""
    failed = {limit.wording.raise_key for limit in node_limits(quick_config, machine)} - {""}
    named = failed | set(restrictions(quick_config, machine))
    assert "force limits of machine.limits" in failed
    assert [(one, other) for one in named for other in named if one != other and one in other] == []
