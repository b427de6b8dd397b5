"""Stage one as a whole: solve, follow the moves of the route, forbid those that fail, and solve again."""

from collections.abc import Callable

import numpy as np

from pipeline.config import Config, RouteConfig
from pipeline.errors import InfeasibleError, NoSolutionError
from pipeline.limits import move_limits
from pipeline.machine.geometry import Machine
from pipeline.progress import QUIET, Monitor
from pipeline.route.bounds.prices import priced_bounds
from pipeline.route.infeasible import require_route, too_few_routes, without_route
from pipeline.route.metric import ROUNDING
from pipeline.route.moves.candidates import find_moves
from pipeline.route.moves.check import check_pairs, is_directed
from pipeline.route.moves.rejections import Rejection
from pipeline.route.moves.screen import Screen
from pipeline.route.problem import RouteProblem
from pipeline.route.regions.table import RegionTable
from pipeline.route.result import Route, Search
from pipeline.route.search.objective import find_best
from pipeline.route.search.optimum import ProvenOptimum
from pipeline.route.search.placement import PlacedRoute, place_route, rejected_moves
from pipeline.route.search.states import expand_states, near_route
from pipeline.solvers.highs import solver_name
from pipeline.status import Status

Follow = Callable[[RouteProblem, PlacedRoute], list[tuple[int, Rejection]]]
"""Follows the moves of a route; gives the first step of each inadmissible one, and why it is."""


def plan_route(config: Config, machine: Machine, regions: RegionTable, monitor: Monitor = QUIET) -> Route:
    """Find the route that `route.objective` and `route.alternative` ask for, every move followed continuously.

    By default it is the one of least sum of kappa (5), proven over the admitted moves.

    Raises
    ------
    InfeasibleError
        When there is no such route (proven).
    NoSolutionError
        When the solver's time limit or the rounds run out, or the moves need too much memory.
    """
    return chosen_route(config.route, plan_routes(config, machine, regions, config.route.alternative, monitor))


def chosen_route(options: RouteConfig, routes: list[Route]) -> Route:
    """Give the route that `route.alternative` asks for.

    Raises
    ------
    InfeasibleError
        When there are fewer routes.
    """
    if len(routes) < options.alternative:
        raise too_few_routes(options, len(routes))
    return routes[options.alternative - 1]


def plan_routes(
    config: Config, machine: Machine, regions: RegionTable, count: int, monitor: Monitor = QUIET
) -> list[Route]:
    """Find the `count` best routes, each straying `route.alternative_distance` from all better ones somewhere.

    They are in the order of their cost, and fewer when there are no more (proven).

    Raises
    ------
    InfeasibleError
        When there is no route at all (proven).
    NoSolutionError
        When the solver's time limit or the rounds run out, or the moves need too much memory.
    """
    moves = find_moves(config, machine, regions, monitor)
    return solve_problem(RouteProblem.of(config, machine, regions, moves, monitor), count)


def solve_problem(
    problem: RouteProblem, count: int = 1, screen: Screen | None = None, follow: Follow = rejected_moves
) -> list[Route]:
    """Find the `count` best routes of a problem, as `plan_routes` does.

    Parameters
    ----------
    screen : Screen
        Knows which moves between regions are bad; by default it follows them.
    follow : callable
        Follows the moves of a route.
    """
    screen = _screen(problem) if screen is None else screen
    routes: list[Route] = []
    for rank in range(1, count + 1):
        if rank > 1:
            problem.monitor.progress(f"route: alternative {rank}")
        try:
            routes.append(_best_route(problem, routes, screen, follow))
        except InfeasibleError:
            if not routes:
                raise
            break
    return routes


def _screen(problem: RouteProblem) -> Screen:
    config, machine, regions = problem.config, problem.machine, problem.regions
    return Screen(
        lambda source, target: check_pairs(config, machine, regions, source, target).rejections,
        len(regions),
        directed=is_directed(move_limits(config, machine)),
    )


def _best_route(problem: RouteProblem, better: list[Route], screen: Screen, follow: Follow) -> Route:
    """Find the best route that strays from the better ones: solve, follow, forbid what fails, solve again."""
    options, regions, progress = problem.options, problem.regions, problem.monitor.progress
    near = [near_route(regions, problem.steps, route.region, options.alternative_distance) for route in better]
    graph = expand_states(regions, problem.moves, np.array(near, dtype=bool).reshape(-1, len(regions)))
    progress("route: shortest paths")
    bounds = priced_bounds(graph.regions, graph.moves, problem.cost, problem.budgets, progress)
    require_route(problem, graph, bounds)
    best: ProvenOptimum | None = None
    for round_ in range(1, options.max_rounds + 1):
        progress(f"route: round {round_}, {screen.rejections.total()} moves forbidden")
        best = find_best(problem, graph, bounds, screen, best)
        if best is None:
            raise without_route(problem, graph, screen)
        placed = place_route(problem, best.sequence)
        found = follow(problem, placed)
        if not found:
            return _route(placed, _search(placed, best, screen, len(problem.moves), round_))
        for step, rejection in found:
            # Gates may have been exchanged for their twins: forbid the move between either.
            for rows in (placed.region.tolist(), best.sequence.region.tolist()):
                screen.forbid(rows[step], rows[step + 1], rejection)
    raise NoSolutionError(
        "route",
        f"after {options.max_rounds} rounds the best route still has moves that fail when followed continuously "
        f"({screen.report})",
        "raise route.max_rounds, or choose a finer grid: moves become shorter and fail less",
    )


def _search(placed: PlacedRoute, best: ProvenOptimum, screen: Screen, moves: int, rounds: int) -> Search:
    """Record how the optimum was proven."""
    return Search(
        solver=solver_name(),
        bound=best.bound,
        gap=_gap(placed.objective, best.bound),
        relaxation=best.relaxation,
        threshold=best.threshold,
        core_regions=best.regions,
        core_columns=best.sequence.columns,
        moves=moves,
        rounds=rounds,
        followed_moves=screen.followed,
        forbidden_moves=screen.rejections.total(),
    )


def _route(placed: PlacedRoute, search: Search) -> Route:
    return Route(
        region=placed.region,
        modes=placed.steps.modes,
        gates=placed.steps.gates,
        visits=placed.visits,
        pose=placed.pose,
        q_m=placed.q_m,
        kappa=placed.steps.kappa,
        objective=placed.objective,
        status=Status.OPTIMAL,
        search=search,
    )


def _gap(objective: float, bound: float) -> float:
    """Compute the relative distance of the objective to its bound; rounding in either sum counts as none."""
    gap = (objective - bound) / objective
    return gap if gap > ROUNDING else 0.0
