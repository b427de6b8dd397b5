"""Routes backwards: where the best route there is, driven backwards, the best route back.

Moves cost the same in both directions (the sum (5) but for kappa of the goal, which every route leaves out), budgets
count the same, and gates are there in both working modes of their arm: the working mode changes on leaving the gate,
so that the way back takes its twin. A way back is then admitted as the way there is, and every route has one of the
same cost less that constant. It is not so where a limit depends on the direction of motion (friction), where straight
ends leave and reach a station differently, or for alternatives, which depend on what was found before.
"""

from dataclasses import replace

import numpy as np

from pipeline.config import Config
from pipeline.limits import move_limits, path_limits
from pipeline.limits.approach import approaches
from pipeline.machine.geometry import Machine
from pipeline.route.moves.check import is_directed
from pipeline.route.planner import as_route
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.solution import StepSequence
from pipeline.route.result import Route
from pipeline.route.search.placement import place_route, rejected_moves
from pipeline.solvers.highs import Outcome


def is_reversible(config: Config, machine: Machine) -> bool:
    """Tell whether the best route from one station to another, backwards, is the best one back.

    Routes found with parallel rails in place of others are moved to these, and not those of the grid any more.
    """
    alone = not approaches(config) and config.route.alternative == 1 and machine.has_parallel_rails
    return alone and not is_directed(move_limits(config, machine))


def is_path_reversible(config: Config, machine: Machine) -> bool:
    """Tell whether a path, backwards, keeps all limits of the way back; friction of any drive may prevent that."""
    return is_reversible(config, machine) and not is_directed(path_limits(config, machine))


def reversed_route(problem: RouteProblem, route: Route) -> Route | None:
    """Give a route backwards, as one of the problem of the way back; None if its moves turn out not to hold there.

    All rules are checked, and all moves followed, again. The bound is moved by as much as the objective.

    Parameters
    ----------
    problem : RouteProblem
        That of the way back: its regions are those of the way there but for start and goal, the last two rows.

    Raises
    ------
    NoSolutionError
        When it breaks a rule, which nothing that is reversible does.
    """
    regions = problem.regions
    rows = np.concatenate([[regions.start], route.region[-2:0:-1], [regions.goal]])
    outcome = Outcome(route.status, np.empty(0), route.objective, route.search.bound, route.search.gap)
    x = route.pose[::-1, 0]
    placed = place_route(problem, StepSequence(rows, x, outcome, route.search.core_columns, route.search.solver))
    if rejected_moves(problem, placed):
        return None
    moved = placed.objective - route.objective
    search = replace(route.search, bound=route.search.bound + moved)
    return as_route(problem, placed, search, route.status)
