"""Proof of a least cost over the admitted moves, by cores or by a program over all regions at a time.

The core holds every route of cost at most a threshold, so that its optimum is the optimum when it is at most
the threshold. The threshold starts just above the best bound and is raised until that is so: exact always.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import IntArray
from pipeline.errors import NoSolutionError
from pipeline.route.bounds.shortest_paths import Bounds, cheap_moves, shortest_paths, shortest_route
from pipeline.route.metric import ROUNDING
from pipeline.route.moves.candidates import Moves
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.core import build_core
from pipeline.route.programs.exclusions import excluded_pairs
from pipeline.route.programs.solution import StepSequence, solve_steps
from pipeline.route.programs.whole import WHOLE_PROGRAMS
from pipeline.route.programs.travel_program import Tangents
from pipeline.route.search.outer_approximation import solve_core
from pipeline.route.search.states import StateGraph
from pipeline.solvers.highs import Outcome
from pipeline.status import Status

_GROWTH = 3.0
_AHEAD = 1.1
"""Moves are picked for thresholds up to this many times the present one: most of them are too costly for any."""
_SCREENED_EARLY = 20_000
"""Cores of at most this many arcs are screened before their threshold is lowered, larger ones just before the solve."""

Screening = Callable[[Moves, Moves, IntArray], Moves]
"""Follows the moves of a core (first), and leaves all known to be bad out of others (second); rows are mapped to
those of the region table by the third, (n,)."""

_NO_MOVES = Moves(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))


def keep_all(core: Moves, moves: Moves, base: IntArray) -> Moves:
    """Screen nothing: all moves are admissible."""
    return moves


@dataclass(frozen=True, eq=False)
class ProvenOptimum:
    """A proven optimum over the moves admitted so far.

    Attributes
    ----------
    sequence : StepSequence
        Rows of the region table, and x, of the steps.
    threshold : float
        T of the core it was proven on; infinite for a program over all regions.
    regions : int
        Number of regions of the program.
    relaxation : float
        Bound on the cost when the step budget is left out, and x but for its price.
    cap : float
        Cap on kappa: the least that leaves a route where the largest kappa counts, infinite where only the sum does.
    """

    sequence: StepSequence
    threshold: float
    regions: int
    relaxation: float
    cap: float = np.inf

    @property
    def objective(self) -> float:
        """The least cost, as the solver gives it."""
        return self.sequence.outcome.objective

    @property
    def bound(self) -> float:
        """Proven lower bound on the cost."""
        return self.sequence.outcome.bound


def find_optimum(
    problem: RouteProblem,
    graph: StateGraph,
    bounds: Bounds,
    at_least: float = 0.0,
    screen: Screening = keep_all,
) -> ProvenOptimum | None:
    """Find the route of least cost with the configured formulation; None: there is no route (proven).

    Parameters
    ----------
    bounds : Bounds
        Those of the graph.
    at_least : float
        Known not to exceed the optimum: that of an earlier round with more moves.
    screen : callable
        Is asked to screen every core before it is solved; programs over all regions do not ask.

    Raises
    ------
    NoSolutionError
        When the solver's time limit ends a solve.
    """
    if problem.options.formulation in WHOLE_PROGRAMS:
        return solve_whole(problem, graph, bounds)
    return prove_on_core(problem, graph, bounds, at_least, screen)


def solve_whole(problem: RouteProblem, graph: StateGraph, bounds: Bounds) -> ProvenOptimum | None:
    """Solve the paper's or the compact program over all regions: for small grids, and for comparison.

    Raises
    ------
    NoSolutionError
        When the solver's time limit ends the solve.
    """
    options, regions, N = problem.options, graph.regions, problem.options.step_budget
    whole = WHOLE_PROGRAMS[options.formulation]
    problem.monitor.progress(f"route: writing the {options.formulation} program")
    excluded = excluded_pairs(problem.config, regions, graph.moves)
    program = whole.build(regions, excluded, problem.steps, N, problem.budgets)
    found = solve_steps(program, lambda values: whole.read(values, regions, N), options.time_limit_s, problem.monitor)
    if found.outcome.status is Status.INFEASIBLE:
        return None
    if found.outcome.status is not Status.OPTIMAL:
        raise _unproven(found.outcome, np.inf)
    return ProvenOptimum(_in_table(found, graph), np.inf, len(regions), bounds.optimum)


def prove_on_core(
    problem: RouteProblem,
    graph: StateGraph,
    bounds: Bounds,
    at_least: float = 0.0,
    screen: Screening = keep_all,
) -> ProvenOptimum | None:
    """Raise the threshold until the optimum over the core is at most it, hence optimal; None: there is no route.

    Before a core is solved its moves are screened; bad ones leave the graph, and the core is built again.

    Raises
    ------
    NoSolutionError
        When the solver's time limit ends a solve.
    """
    options, regions, moves = problem.options, graph.regions, graph.moves
    ceiling = options.step_budget * problem.cost.most(regions)
    # Costs of zero are possible: a least cost of zero has no relative margin.
    unit = ceiling / options.step_budget**2
    margin, known = options.threshold_margin, np.inf
    excluded = max(bounds.optimum, at_least)
    threshold, reach, part = min(excluded + margin * max(excluded, unit), ceiling), -np.inf, moves
    tangents = Tangents(regions, problem.cost, bounds.prices.travel)
    while True:
        if threshold > reach:
            reach = _AHEAD * threshold
            part = screen(_NO_MOVES, cheap_moves(moves, bounds, reach), graph.base)
            if problem.cost.counts_x and known == np.inf:
                known = _cost_along(problem, graph, part, bounds, screen, tangents)
                threshold = min(threshold, known)
        core = build_core(problem, regions, part, bounds, threshold)
        problem.monitor.progress(
            f"route: core of {core.regions:,} regions, {len(core.tail):,} arcs, threshold {threshold:.2f}"
        )
        # The core's own bound takes x and the step budget into account: a lower threshold, and a smaller core, may do.
        lower = core.bound * (1.0 + options.threshold_margin)
        lowered = not core.empty and core.bound > excluded and lower < min(threshold, known)
        if not lowered or len(core.tail) <= _SCREENED_EARLY:
            left = screen(core.moves, part, graph.base)
            if len(left) < len(part):
                part = left
                continue
        if lowered:
            threshold, margin = lower, options.threshold_margin
            continue
        if not core.empty:
            found = solve_core(problem, regions, core, tangents)
            if found.outcome.status not in (Status.OPTIMAL, Status.INFEASIBLE):
                raise _unproven(found.outcome, threshold)
            if found.outcome.objective <= threshold * (1.0 + ROUNDING):
                return ProvenOptimum(_in_table(found, graph), threshold, core.regions, bounds.optimum)
            known = min(known, found.outcome.objective)
        if threshold >= ceiling:
            return None
        excluded = threshold
        margin *= _GROWTH
        threshold = min(excluded + margin * max(excluded, unit), known, ceiling)


def _cost_along(
    problem: RouteProblem, graph: StateGraph, moves: Moves, bounds: Bounds, screen: Screening, tangents: Tangents
) -> float:
    """Find the cost of a route along a shortest path of admissible moves: with the best x often the optimum itself."""
    least = shortest_paths(graph.regions, moves, problem.cost, bounds.prices)
    if not np.isfinite(least.optimum):
        return np.inf
    path = shortest_route(graph.regions, moves, problem.cost, least)
    pairs = np.unique(np.column_stack([path[:-1], path[1:]]), axis=0)
    along = Moves(pairs[:, 0], pairs[:, 1])
    if len(left := screen(along, moves, graph.base)) < len(moves):
        return _cost_along(problem, graph, left, bounds, screen, tangents)
    core = build_core(problem, graph.regions, along, bounds, problem.options.step_budget * problem.cost.most(graph.regions))
    if core.empty:
        return np.inf
    found = solve_core(problem, graph.regions, core, tangents)
    return found.outcome.objective if found.outcome.status is Status.OPTIMAL else np.inf


def _in_table(sequence: StepSequence, graph: StateGraph) -> StepSequence:
    """Give a sequence of the graph in rows of the region table."""
    return replace(sequence, region=graph.base[sequence.region])


def _unproven(outcome: Outcome, threshold: float) -> NoSolutionError:
    return NoSolutionError(
        "route",
        f"HiGHS stopped without a proof ({outcome.status}); least cost so far {outcome.objective:.3f}, "
        f"bound {outcome.bound:.3f}, threshold {threshold:.3f}",
        outcome.status.advice + " The key is route.time_limit_s.",
        {"status": outcome.status.value, "objective": outcome.objective, "bound": outcome.bound},
    )
