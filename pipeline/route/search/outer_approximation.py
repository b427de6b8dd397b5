"""The least cost over a core: one program, or for costs that depend on x programs with ever more tangents.

Outer approximation (Duran and Grossmann, 1986): a mixed-integer program over tangents of the convex costs gives a
lower bound and a sequence of moves; the best x of that sequence gives an upper bound, and the tangents there. A
sequence that is found again has been bounded by its own cost, so that the bounds meet after finitely many programs.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from pipeline.route.cost.objectives import route_cost
from pipeline.route.metric import ROUNDING
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.core import Core
from pipeline.route.programs.core_program import build_core_program, read_core
from pipeline.route.programs.solution import StepSequence, solve_steps
from pipeline.route.programs.travel_program import Tangents, build_travel_program
from pipeline.route.regions.table import RegionTable
from pipeline.route.search.x_positions import cheapest_x
from pipeline.solvers.highs import solve_program
from pipeline.status import Status

CLOSED = 1e-7
"""Relative distance of the bounds at which they count as met."""
_PATIENCE = 5
"""Programs in a row that move neither bound."""


def solve_core(problem: RouteProblem, regions: RegionTable, core: Core, tangents: Tangents) -> StepSequence:
    """Find the route of least cost over a core that is not empty; `regions` are those of its rows.

    The outcome's objective is the cost of the route; it is above the core's threshold when no route in it is as cheap.
    """
    if not problem.cost.counts_x:
        return _solve(problem, core, None)
    _tighten(problem, core, tangents)
    best: StepSequence | None = None
    last, stalled = -np.inf, 0
    while True:
        relaxed = _solve(problem, core, tangents)
        if relaxed.outcome.status is not Status.OPTIMAL:
            return relaxed
        bound = relaxed.outcome.bound
        placed = _with_best_x(problem, regions, relaxed, tangents)
        improved = best is None or placed.outcome.objective < best.outcome.objective
        best = placed if best is None or improved else best
        problem.monitor.progress(f"route: cost between {bound:.4f} and {best.outcome.objective:.4f}")
        if best.outcome.objective - bound <= CLOSED * max(abs(best.outcome.objective), 1e-9):
            return _bounded(best, min(bound, best.outcome.objective), relaxed.columns)
        # Above the threshold nothing is proven by going on, nor where rounding keeps the bounds apart.
        stalled = 0 if improved or bound > last else stalled + 1
        if bound > core.threshold * (1.0 + ROUNDING) or stalled == _PATIENCE:
            return _bounded(best, bound, relaxed.columns)
        last = max(bound, last)


def _solve(problem: RouteProblem, core: Core, tangents: Tangents | None) -> StepSequence:
    if tangents is None:
        program, read, gap = build_core_program(core), partial(read_core, core=core), 0.0
    else:
        travelling = build_travel_program(core, tangents)
        program, read, gap = travelling.program, travelling.read, CLOSED / 2.0
    return solve_steps(program, read, problem.options.time_limit_s, problem.monitor, gap)


def _tighten(problem: RouteProblem, core: Core, tangents: Tangents) -> None:
    """Add tangents until they make the continuous relaxation that of the costs themselves: linear programs are cheap."""
    source, target = core.region[core.tail], core.region[core.head]
    last = -np.inf
    while True:
        travelling = build_travel_program(core, tangents)
        relaxed = replace(travelling.program, integer=np.zeros_like(travelling.program.integer))
        outcome = solve_program(relaxed, problem.options.time_limit_s)
        if outcome.status is not Status.OPTIMAL or outcome.objective <= last + CLOSED / 10.0 * abs(last):
            return
        last = outcome.objective
        used, travel = outcome.values[: len(source)], outcome.values[travelling.travel]
        arcs = np.flatnonzero(used > 1e-6)
        problem.monitor.progress(f"route: relaxed cost {last:.4f}")
        tangents.add(source[arcs], target[arcs], travel[arcs] / used[arcs])


def _with_best_x(
    problem: RouteProblem, regions: RegionTable, found: StepSequence, tangents: Tangents
) -> StepSequence:
    """Choose the best x of a sequence, without waits where they save nothing, and touch the costs of its steps there."""
    rows = found.region
    tangents.add(rows[:-1], rows[1:], np.diff(found.x_m))
    best = cheapest_x(problem, regions, rows) or (found.x_m, route_cost(problem.cost, regions, rows, found.x_m))
    moved = rows[np.append(True, rows[1:] != rows[:-1])]
    if len(moved) < len(rows) and (shorter := cheapest_x(problem, regions, moved)) is not None:
        if shorter[1] <= best[1] * (1.0 + CLOSED / 10.0):
            rows, best = moved, shorter
    x, cost = best
    placed = replace(found, region=rows, x_m=x, outcome=replace(found.outcome, objective=cost))
    tangents.add(rows[:-1], rows[1:], np.diff(x))
    return placed


def _bounded(best: StepSequence, bound: float, columns: int) -> StepSequence:
    return replace(best, outcome=replace(best.outcome, bound=bound), columns=columns)
