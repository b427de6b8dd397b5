"""The least cost over a core where travel along X costs: programs with ever more tangents.

Outer approximation (Duran and Grossmann, 1986): a mixed-integer program over tangents of the convex costs gives a
lower bound and a sequence of moves; the best x of that sequence gives an upper bound, and the tangents there. A
sequence that is found again has been bounded by its own cost, so that the bounds meet after finitely many programs.
"""

from dataclasses import replace

import numpy as np

from pipeline.route.core.build import Core
from pipeline.route.cost.objectives import route_cost
from pipeline.route.metric import ROUNDING
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.solution import StepSequence, solve_steps
from pipeline.route.programs.travel_program import Tangents, build_travel_program
from pipeline.route.search.best_so_far import CLOSED
from pipeline.route.search.x_positions import cheapest_x
from pipeline.solvers.highs import solve_program
from pipeline.status import Status

_TIGHT = 1e-5
"""Relative gain of the relaxation below which no more tangents are added before the first program."""
_PATIENCE = 5
"""Programs in a row that move neither bound."""


def approximate(
    problem: RouteProblem, core: Core, tangents: Tangents, known: StepSequence | None = None
) -> StepSequence:
    """Find the route of least cost over a core that is not empty; the tangents are those of its rows, and grow.

    `known` is a route found before, in rows of the same table.

    The outcome's objective is the cost of the route; it is above the core's threshold when no route in it is as cheap.
    """
    _tighten(problem, core, tangents)
    best = known
    last, stalled = -np.inf, 0
    while True:
        program = build_travel_program(core, tangents)
        deadline, monitor = problem.deadline, problem.deadline.shown(problem.monitor)
        relaxed = solve_steps(program.program, program.read, deadline.left_s, monitor, CLOSED / 2.0)
        bound = max(last, relaxed.outcome.bound)
        if relaxed.outcome.status is not Status.OPTIMAL:
            return relaxed if best is None else _ended(best, relaxed, bound)
        placed = with_best_x(problem, relaxed, tangents)
        improved = best is None or placed.outcome.objective < best.outcome.objective
        best = placed if best is None or improved else best
        objective = best.outcome.objective
        problem.monitor.progress(f"route: cost between {bound:.4f} and {objective:.4f}")
        if objective - bound <= CLOSED * max(abs(objective), 1e-9):
            return _ended(best, relaxed, bound)
        # Above the threshold nothing is proven by going on, nor where rounding keeps the bounds apart.
        stalled = 0 if improved or bound > last else stalled + 1
        if bound > core.threshold * (1.0 + ROUNDING) or stalled == _PATIENCE:
            return _ended(best, relaxed, bound)
        last = bound


def _tighten(problem: RouteProblem, core: Core, tangents: Tangents) -> None:
    """Add tangents until the continuous relaxation is that of the costs themselves: linear programs are cheap."""
    source, target = core.region[core.tail], core.region[core.head]
    last = -np.inf
    while True:
        travelling = build_travel_program(core, tangents)
        relaxed = replace(travelling.program, integer=np.zeros_like(travelling.program.integer))
        outcome = solve_program(relaxed, problem.deadline.left_s)
        if outcome.objective > core.threshold * (1.0 + ROUNDING):
            return
        if outcome.status is not Status.OPTIMAL or outcome.objective <= last + _TIGHT * abs(last):
            return
        last = outcome.objective
        used, travel = outcome.values[: len(source)], outcome.values[travelling.travel]
        arcs = np.flatnonzero(used > 1e-6)
        problem.monitor.progress(f"route: relaxed cost {last:.4f}")
        tangents.add(source[arcs], target[arcs], travel[arcs] / used[arcs])


def with_best_x(problem: RouteProblem, found: StepSequence, tangents: Tangents) -> StepSequence:
    """Choose the best x of a sequence, without waits that save nothing, and touch the costs of its steps there."""
    rows, regions = found.region, tangents.regions
    tangents.add(rows[:-1], rows[1:], np.diff(found.x_m))
    best = cheapest_x(problem, regions, rows) or (found.x_m, route_cost(problem.cost, regions, rows, found.x_m))
    moved = rows[np.append(True, rows[1:] != rows[:-1])]
    shorter = cheapest_x(problem, regions, moved) if len(moved) < len(rows) else None
    if shorter is not None and shorter[1] <= best[1] * (1.0 + CLOSED / 10.0):
        rows, best = moved, shorter
    x, cost = best
    placed = replace(found, region=rows, x_m=x, outcome=replace(found.outcome, objective=cost))
    tangents.add(rows[:-1], rows[1:], np.diff(x))
    return placed


def _ended(best: StepSequence, last: StepSequence, bound: float) -> StepSequence:
    """Give the best sequence with the status of the last program and what is proven."""
    objective = best.outcome.objective
    bound = min(bound, objective)
    gap = (objective - bound) / objective if objective > 0.0 else 0.0
    return replace(
        best, outcome=replace(best.outcome, status=last.outcome.status, bound=bound, gap=gap), columns=last.columns
    )
