"""Proofs that there is no route, with the keys to change."""

import numpy as np

from pipeline.config import Config, RouteConfig
from pipeline.errors import InfeasibleError
from pipeline.limits import relaxations
from pipeline.machine.geometry import Machine
from pipeline.route.bounds.shortest_paths import Bounds, fewest_positions, least_use, shortest_route
from pipeline.route.metric import ROUNDING
from pipeline.route.moves.screen import Screen
from pipeline.route.problem import RouteProblem
from pipeline.route.search.states import StateGraph
from pipeline.status import Status


def require_route(problem: RouteProblem, graph: StateGraph, bounds: Bounds) -> None:
    """Refuse a problem that the graph alone proves to have no route.

    Raises
    ------
    InfeasibleError
        When the goal cannot be reached, or only with more positions or more of a budget than allowed.
    """
    regions, moves = graph.regions, graph.moves
    if not np.isfinite(bounds.optimum):
        reached = int(np.isfinite(bounds.forward).sum())
        raise _infeasible(
            f"no route exists on these {len(regions):,} regions. From the start {reached:,} of them can be reached "
            f"over {len(moves):,} admitted moves, and the goal is not among them (proven by exhausting them)",
            _not_tried(restrictions(problem.config, problem.machine)),
            regions=len(regions),
            moves=len(moves),
            reached=reached,
        )
    N = problem.options.step_budget
    if (
        len(shortest_route(regions, moves, problem.cost, bounds)) > N
        and (fewest := fewest_positions(regions, moves) or 1) > N
    ):
        raise _infeasible(
            f"every route needs at least {fewest} positions (proven); route.step_budget allows {N}",
            f"raise route.step_budget; {fewest} is a lower bound, and may not be enough",
            fewest_positions=fewest,
        )
    for budget in problem.budgets:
        least = least_use(regions, moves, budget)
        if least > budget.left(regions) + ROUNDING:
            shown = budget.shown(regions, least)
            raise _infeasible(
                f"every route uses at least {shown} of task.budget.{budget.key} (proven)",
                f"raise task.budget.{budget.key}, or remove it; {shown} is a lower bound, and may not be enough",
                budget=budget.key,
            )


def without_route(problem: RouteProblem, graph: StateGraph, screen: Screen) -> InfeasibleError:
    """Make the error that no sequence of regions fulfils everything that is asked."""
    asked = ", and the budgets of the task" if problem.budgets else ""
    failed = screen.rejections.total()
    because = f", after {failed} moves were forbidden that fail when followed ({screen.report})" if failed else ""
    return _infeasible(
        f"no route exists on these {len(graph.regions):,} regions within the step budget and the travel along X"
        f"{asked}{because} (proven)",
        _not_tried(_keys_to_raise(problem, screen)),
        regions=len(graph.regions),
        moves=len(graph.moves),
    )


def too_few_routes(options: RouteConfig, count: int) -> InfeasibleError:
    """Make the error that there are only `count` routes, fewer than `route.alternative` asks for."""
    there, stray = ("is only 1 route", "strays") if count == 1 else (f"are only {count} routes", "stray")
    return _infeasible(
        f"there {there} that {stray} {options.alternative_distance:g} grid steps from each better one (proven)",
        "lower route.alternative or route.alternative_distance, or raise route.step_budget",
        routes=count,
    )


def _keys_to_raise(problem: RouteProblem, screen: Screen) -> list[str]:
    """List the keys that would let more routes through; those that most moves failed on come first."""
    failed = [rejection.raise_key for rejection, _ in screen.rejections.most_common() if rejection.raise_key]
    budgets = [f"task.budget.{budget.key}" for budget in problem.budgets]
    keys = [*failed, *budgets, "route.step_budget", "route.x_step_m", *restrictions(problem.config, problem.machine)]
    return list(dict.fromkeys(keys))


def restrictions(config: Config, machine: Machine) -> list[str]:
    """List the keys of all that keeps regions and moves out, and that this configuration has."""
    keys = [relaxation.key for relaxation in relaxations(config, machine) if not relaxation.part_of]
    locked = ["task.locked_axes"] if config.task.locked_axes else []
    return list(dict.fromkeys([*locked, *(["task.visit"] if config.task.visit else []), *keys, "route.grid"]))


def _not_tried(keys: list[str]) -> str:
    return f"let one or more of {', '.join(keys)} give; which of them would do was not tried"


def _infeasible(reason: str, advice: str, **facts: object) -> InfeasibleError:
    return InfeasibleError("route", reason, advice, {"status": Status.INFEASIBLE.value, **facts})
