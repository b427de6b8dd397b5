"""Stage one as a whole: solve, follow the moves of the route, forbid those that fail, and solve again."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipeline.arguments import require_whole
from pipeline.arrays import IntArray
from pipeline.config import Config, RouteConfig
from pipeline.errors import InfeasibleError, NoSolutionError
from pipeline.limits import move_limits
from pipeline.machine.geometry import Machine
from pipeline.machine.rails import with_parallel_rails
from pipeline.parallel import blocks
from pipeline.progress import QUIET, Monitor
from pipeline.route.bounds.bottleneck import least_cap, moves_within
from pipeline.route.bounds.prices import priced_bounds
from pipeline.route.infeasible import require_route, too_few_routes, without_route
from pipeline.route.metric import ROUNDING
from pipeline.route.moves.candidates import find_moves
from pipeline.route.moves.check import check_pairs, is_directed
from pipeline.route.moves.rejections import Rejection
from pipeline.route.moves.screen import Screen
from pipeline.route.own_rails import on_own_rails
from pipeline.route.problem import RouteProblem
from pipeline.route.regions.table import RegionTable
from pipeline.route.result import Route, Search
from pipeline.route.search.best_so_far import Optimum
from pipeline.route.search.objective import find_best
from pipeline.route.search.placement import PlacedRoute, place_route, rejected_moves
from pipeline.route.search.states import StateGraph, expand_states, near_route
from pipeline.route.straight_ends import require_straight_ends, with_straight_ends
from pipeline.status import Status

_FOLLOWED = 8_192
"""Moves followed between two looks at the clock."""

_FINE = 1.01
"""Ratio of neighbouring caps at which the least largest kappa is looked for."""

_MOST_ROUTES = 1_000
"""More routes than a search could give."""

Follow = Callable[[RouteProblem, PlacedRoute], list[tuple[int, Rejection]]]
"""Follows the moves of a route; gives the first step of each inadmissible one, and why it is."""


def plan_route(config: Config, machine: Machine, regions: RegionTable, monitor: Monitor = QUIET) -> Route:
    """Find the route that `route.objective` and `route.alternative` ask for, every move followed continuously.

    By default it is the one of least integral of kappa, proven over the admitted moves. When `route.time_limit_s` ends
    the search it is the best one found so far: its status is then UNPROVEN, and `search` has its bound and gap.

    Raises
    ------
    ConfigError
        When the straight move between an end and its approach pose fails.
    InfeasibleError
        When there is no such route (proven).
    NoSolutionError
        When the time runs out before a route is found, the rounds run out, or the moves need too much memory.
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

    They are in the order of their cost, and fewer when there are no more (proven). A route beside a better one that is
    not proven optimal is not proven either.

    Raises
    ------
    ConfigError
        When the straight move between an end and its approach pose fails.
    InfeasibleError
        When there is no route at all (proven).
    NoSolutionError
        When the time runs out before all are found, the rounds run out, or the moves need too much memory.
    ArgumentError
        When the count is not a whole number of at least one.
    """
    count = require_whole("count", count, 1, _MOST_ROUTES)
    require_straight_ends(config, machine)
    parallel = with_parallel_rails(machine)
    moves = find_moves(config, parallel, regions, monitor)
    routes = solve_problem(RouteProblem.of(config, parallel, regions, moves, monitor), count)
    return [on_own_rails(config, machine, with_straight_ends(config, parallel, route)) for route in routes]


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
    screen = screen_of(problem) if screen is None else screen
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


def screen_of(problem: RouteProblem) -> Screen:
    """Make the screen that follows the moves of a problem, and knows none yet; problems with the same limits share it.

    It raises OutOfTimeError when the time runs out.
    """
    config, machine, regions = problem.config, problem.machine, problem.regions
    return Screen(
        lambda source, target: [
            rejection
            for part in blocks(len(source), _FOLLOWED)
            for rejection in _check_in_time(problem, source[part], target[part])
        ],
        len(regions),
        directed=is_directed(move_limits(config, machine)),
    )


def _check_in_time(problem: RouteProblem, source: IntArray, target: IntArray) -> list[Rejection | None]:
    problem.deadline.require()
    return check_pairs(problem.config, problem.machine, problem.regions, source, target).rejections


def _best_route(problem: RouteProblem, better: list[Route], screen: Screen, follow: Follow) -> Route:
    """Find the best route that strays from the better ones: solve, follow, forbid what fails, solve again."""
    options, regions, progress = problem.options, problem.regions, problem.monitor.progress
    near = [near_route(regions, problem.steps, route.region, options.alternative_distance) for route in better]
    graph = expand_states(regions, problem.moves, np.array(near, dtype=bool).reshape(-1, len(regions)), options)
    progress("route: shortest paths")
    shortest = problem.shortest if graph.regions is regions else None
    bounds = priced_bounds(graph.regions, graph.moves, problem.cost, problem.budgets, progress, shortest)
    require_route(problem, graph, bounds)
    best: Optimum | None = None
    for round_ in range(1, options.max_rounds + 1):
        progress(f"route: round {round_}, {screen.rejections.total()} moves forbidden")
        best = find_best(problem, graph, bounds, screen, best)
        if best is None:
            raise without_route(problem, graph, screen)
        placed = place_route(problem, best.sequence)
        found = follow(problem, placed)
        if not found:
            proven = best.proven and all(route.status is Status.OPTIMAL for route in better)
            status = Status.OPTIMAL if proven else Status.UNPROVEN
            search = _search(placed, best, screen, len(problem.moves), round_)
            largest = float(placed.steps.kappa.max())
            least = _least_kappa_max(problem, graph, largest) if problem.guided else np.inf
            return as_route(problem, placed, replace(search, least_kappa_max=least), status)
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


def with_guide(problem: RouteProblem, route: Route) -> Route:
    """Add what guides stage two to the best route of a problem that was not `guided`."""
    graph = expand_states(problem.regions, problem.moves, np.empty((0, len(problem.regions)), dtype=bool))
    least = _least_kappa_max(problem, graph, route.kappa_max)
    return replace(route, search=replace(route.search, least_kappa_max=least))


def _least_kappa_max(problem: RouteProblem, graph: StateGraph, largest: float) -> float:
    """Bound the least largest kappa over the graph to one per cent, given that of a route: no other region matters."""
    kappa = graph.regions.kappa
    values = np.minimum(largest * _FINE ** np.ceil(np.log(kappa / largest) / np.log(_FINE)), largest)
    moves = moves_within(graph.moves, kappa, largest)
    return min(least_cap(graph.regions, moves, values, problem.options.step_budget - 1, problem.budgets), largest)


def _search(placed: PlacedRoute, best: Optimum, screen: Screen, moves: int, rounds: int) -> Search:
    """Record how the optimum was proven."""
    return Search(
        solver=best.sequence.solver,
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
        least_kappa_max=np.inf,
    )


def as_route(problem: RouteProblem, placed: PlacedRoute, search: Search, status: Status) -> Route:
    """Give a route that was placed, with how it was found, as the result of the stage."""
    return Route(
        region=placed.region,
        modes=placed.steps.modes,
        gates=placed.steps.gates,
        visits=placed.visits,
        pose=placed.pose,
        q_m=placed.q_m,
        kappa=placed.steps.kappa,
        objective=placed.objective,
        status=status,
        search=search,
        objective_kind=problem.options.objective,
    )


def _gap(objective: float, bound: float) -> float:
    """Compute the relative distance of the objective to its bound; rounding in either sum counts as none."""
    # A goal in the pose of the start is reached at no cost.
    gap = (objective - bound) / objective if objective > 0.0 else 0.0
    return gap if gap > ROUNDING else 0.0
