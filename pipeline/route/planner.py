"""Stage one as a whole: moves, layout, bounds, core, program, and the moves of the route followed until all hold."""

import numpy as np

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import Machine
from pipeline.progress import Monitor, Progress, silent
from pipeline.route.bounds.budget_prices import priced_bounds
from pipeline.route.bounds.budgets import budgets
from pipeline.route.bounds.shortest_paths import Bounds, fewest_moves, least_use, shortest_route
from pipeline.route.metric import step_sizes
from pipeline.route.moves.candidates import Moves, find_moves
from pipeline.limits import move_limits
from pipeline.route.moves.check import check_pairs, is_directed
from pipeline.route.moves.screen import Screen
from pipeline.route.regions.table import RegionTable
from pipeline.route.result import Route, Search
from pipeline.route.search.objective import Best, find_best
from pipeline.route.search.placement import PlacedRoute, flawed_moves, place_route
from pipeline.route.search.states import StateGraph, expand_states, near_route
from pipeline.solvers.highs import solver_name
from pipeline.status import Status


def plan_route(
    config: Config, machine: Machine, regions: RegionTable, progress: Progress = silent, verbose: bool = False
) -> Route:
    """Find the route that `route.objective` and `route.alternative` ask for, every move followed continuously.

    By default it is the one of least sum of kappa (5), proven over the admitted moves.

    Raises
    ------
    NoSolutionError
        When there is no such route (proven), or the solver's time limit or the rounds run out.
    """
    rank = config.route.alternative
    routes = plan_routes(config, machine, regions, rank, progress, verbose)
    if len(routes) < rank:
        there, stray = (
            ("is only 1 route", "strays") if len(routes) == 1 else (f"are only {len(routes)} routes", "stray")
        )
        raise NoSolutionError(
            "route",
            f"there {there} that {stray} {config.route.alternative_distance:g} grid steps from each better one "
            "(proven)",
            "lower route.alternative or route.alternative_distance, or raise route.step_budget",
            {"status": Status.INFEASIBLE.value, "routes": len(routes)},
        )
    return routes[-1]


def plan_routes(
    config: Config,
    machine: Machine,
    regions: RegionTable,
    count: int,
    progress: Progress = silent,
    verbose: bool = False,
) -> list[Route]:
    """Find the `count` best routes, each straying `route.alternative_distance` from all better ones somewhere.

    They are in the order of their cost, and fewer when there are no more (proven).

    Raises
    ------
    NoSolutionError
        When there is no route at all (proven), or the solver's time limit or the rounds run out.
    """
    moves = find_moves(config, machine, regions, Monitor(progress, verbose))
    screen = Screen(
        lambda source, target: check_pairs(config, machine, regions, source, target).rejections,
        len(regions),
        directed=is_directed(move_limits(config, machine)),
    )
    routes: list[Route] = []
    for rank in range(1, count + 1):
        if rank > 1:
            progress(f"route: alternative {rank}")
        try:
            routes.append(_plan(config, machine, regions, moves, screen, routes, progress, verbose))
        except NoSolutionError as error:
            if not routes or error.diagnosis.get("status") != Status.INFEASIBLE.value:
                raise
            break
    return routes


def _plan(
    config: Config,
    machine: Machine,
    regions: RegionTable,
    moves: Moves,
    screen: Screen,
    better: list[Route],
    progress: Progress,
    verbose: bool,
) -> Route:
    """Find the best route that strays from the better ones: solve, follow, forbid what fails, solve again."""
    steps, distance = step_sizes(config.route), config.route.alternative_distance
    near = np.array([near_route(regions, steps, route.region, distance) for route in better], dtype=bool)
    layout = expand_states(regions, moves, near.reshape(-1, len(regions)))
    progress("route: shortest paths")
    bounds = priced_bounds(layout.regions, layout.moves, budgets(config), progress)
    _require_way(config, layout, bounds)
    best: Best | None = None
    for round_ in range(1, config.route.max_rounds + 1):
        progress(f"route: round {round_}, {screen.rejections.total()} moves forbidden")
        best = find_best(config, layout, bounds, screen, best, progress, verbose)
        if best is None:
            raise _no_route(config, layout, screen)
        sequence = best.sequence(layout)
        placed = place_route(config, regions, sequence)
        found = flawed_moves(config, machine, placed)
        if not found:
            return _route(placed, best, screen, len(moves), round_)
        for step, flaw in found:
            # Gates may have been exchanged for their twins: neither is to come again.
            for rows in (placed.region.tolist(), sequence.region.tolist()):
                screen.forbid(rows[step], rows[step + 1], flaw)
    raise NoSolutionError(
        "route",
        f"after {config.route.max_rounds} rounds the best route still has moves that fail when followed continuously "
        f"({screen.report})",
        "raise route.max_rounds, or choose a finer grid: moves become shorter and fail less",
    )


def _require_way(config: Config, layout: StateGraph, bounds: Bounds) -> None:
    """Refuse what the graph alone shows to be impossible: that is a proof."""
    regions, moves = layout.regions, layout.moves
    if not np.isfinite(bounds.optimum):
        reached = int(np.isfinite(bounds.forward).sum())
        raise _infeasible(
            f"no route exists on these {len(regions):,} regions. From the start {reached:,} of them can be reached "
            f"over {len(moves):,} admitted moves, and the goal is not among them (proven by exhausting them)",
            f"allow more tilt (task.tilt_max_deg is {config.task.tilt_max_deg:g}), unlock an axis, allow a larger "
            "route.kappa_max or less clearance, or refine the grid",
            regions=len(regions),
            moves=len(moves),
            reached=reached,
        )
    N = config.route.step_budget
    if len(shortest_route(regions, moves, bounds)) > N and (hops := fewest_moves(regions, moves) or 0) + 1 > N:
        raise _infeasible(
            f"every route needs at least {hops + 1} positions (proven); route.step_budget allows {N}",
            f"set route.step_budget to {hops + 1} or more, or coarsen the grid",
            fewest_positions=hops + 1,
        )
    for budget in bounds.prices.budgets:
        least = least_use(regions, moves, budget)
        if least > budget.left(regions) + 1e-9:
            raise _infeasible(
                f"every route uses at least {budget.shown(regions, least)} of task.budget.{budget.key} (proven)",
                f"allow as much, or remove task.budget.{budget.key}",
                budget=budget.key,
            )


def _no_route(config: Config, layout: StateGraph, screen: Screen) -> NoSolutionError:
    asked = ", and the budgets of the task" if budgets(config) else ""
    flaws = screen.rejections.total()
    because = f", after {flaws} moves were forbidden that fail when followed ({screen.report})" if flaws else ""
    return _infeasible(
        f"no route exists on these {len(layout.regions):,} regions within the step budget and the travel along X"
        f"{asked}{because} (proven)",
        f"raise {' or '.join(_loosened(config, screen))}, allow more tilt, or refine the grid",
        regions=len(layout.regions),
        moves=len(layout.moves),
    )


def _loosened(config: Config, screen: Screen) -> list[str]:
    """The keys that would let more routes through, what most moves failed on first."""
    failed = [rejection.raise_key for rejection, _ in screen.rejections.most_common() if rejection.raise_key]
    return [
        *failed,
        "route.step_budget",
        "route.x_step_m",
        *(f"task.budget.{budget.key}" for budget in budgets(config)),
    ]


def _infeasible(reason: str, advice: str, **facts: object) -> NoSolutionError:
    return NoSolutionError("route", reason, advice, {"status": Status.INFEASIBLE.value, **facts})


def _route(placed: PlacedRoute, best: Best, screen: Screen, moves: int, rounds: int) -> Route:
    """Put the result together: the steps, and how their optimality was proven."""
    bound = best.optimum.sequence.outcome.bound
    search = Search(
        solver=solver_name(),
        bound=bound,
        gap=_gap(placed.objective, bound),
        relaxation=best.relaxation,
        threshold=best.optimum.threshold,
        core_regions=best.optimum.regions,
        core_columns=best.optimum.sequence.columns,
        moves=moves,
        rounds=rounds,
        followed_moves=screen.followed,
        forbidden_moves=screen.rejections.total(),
    )
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
    """Relative distance of the objective to its bound; rounding in either sum counts as none."""
    gap = (objective - bound) / objective
    return gap if gap > 1e-9 else 0.0
