"""The least cost over the admitted moves, by cores or by a program over all regions at a time.

The core holds every route of cost at most a threshold, so that its optimum is the optimum when it is at most
the threshold. The threshold starts just above the best bound and is raised until that is so: exact always.
"""

import numpy as np

from pipeline.route.bounds.shortest_paths import Bounds, cheap_moves
from pipeline.route.core.build import Core, build_core, core_bytes
from pipeline.route.deadline import OutOfTimeError
from pipeline.route.memory import require_memory
from pipeline.route.moves.candidates import Moves
from pipeline.route.moves.screen import Screening, keep_all
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.exclusions import excluded_pairs
from pipeline.route.programs.solution import StepSequence, solve_steps
from pipeline.route.programs.travel_program import Tangents
from pipeline.route.programs.whole import WHOLE_PROGRAMS
from pipeline.route.search.best_so_far import BestSoFar, Optimum, in_table
from pipeline.route.search.core_optimum import solve_core
from pipeline.route.search.first_route import offer_first_route
from pipeline.route.search.states import StateGraph
from pipeline.route.search.tightening import tighten_core
from pipeline.status import Status

_GROWTH = 3.0
_AHEAD = 1.1
"""Moves are picked for thresholds up to this many times the present one: most of them are too costly for any."""
_SCREENED_EARLY = 20_000
"""Cores of at most this many arcs are screened before their threshold is lowered, larger ones just before the solve."""

_NO_MOVES = Moves(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))


def find_optimum(
    problem: RouteProblem,
    graph: StateGraph,
    bounds: Bounds,
    at_least: float = 0.0,
    screen: Screening = keep_all,
) -> Optimum | None:
    """Find the route of least cost with the configured formulation; None: there is no route (proven).

    When the time runs out it is the best route found so far, and not `proven`.

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
    OutOfTimeError
        When the time runs out before a route is found.
    """
    if problem.options.formulation in WHOLE_PROGRAMS:
        return solve_whole(problem, graph, bounds)
    return prove_on_core(problem, graph, bounds, at_least, screen)


def solve_whole(problem: RouteProblem, graph: StateGraph, bounds: Bounds) -> Optimum | None:
    """Solve the paper's or the compact program over all regions: for small grids, and for comparison.

    Raises
    ------
    OutOfTimeError
        When the time runs out before a route is found.
    """
    options, regions, N = problem.options, graph.regions, problem.options.step_budget
    whole = WHOLE_PROGRAMS[options.formulation]
    problem.monitor.progress(f"route: writing the {options.formulation} program")
    excluded = excluded_pairs(problem.config, regions, graph.moves)
    size = whole.size(len(regions), N, len(excluded), len(np.unique(excluded.source)), problem.budgets)
    what = f"the {options.formulation} program of {size.entries:,} matrix entries"
    require_memory(options, size.solved_bytes, what, "set route.formulation to core")
    program = whole.build(regions, excluded, problem.steps, N, problem.budgets)
    deadline, monitor = problem.deadline, problem.deadline.shown(problem.monitor)
    found = solve_steps(program, lambda values: whole.read(values, regions, N), deadline.left_s, monitor)
    if found.outcome.status is Status.INFEASIBLE:
        return None
    bound = max(found.outcome.bound, bounds.optimum)
    if len(found.region) == 0:
        raise deadline.error(bound)
    proven = found.outcome.status is Status.OPTIMAL
    return Optimum(
        sequence=in_table(found, graph),
        threshold=np.inf,
        regions=len(regions),
        relaxation=bounds.optimum,
        bound=found.outcome.bound if proven else bound,
        proven=proven,
    )


def prove_on_core(
    problem: RouteProblem,
    graph: StateGraph,
    bounds: Bounds,
    at_least: float = 0.0,
    screen: Screening = keep_all,
) -> Optimum | None:
    """Raise the threshold until the optimum over the core is at most it, hence optimal; None: there is no route.

    Before a core is solved its moves are screened; bad ones leave the graph, and the core is built again. When the time
    runs out it is the best route found so far, and not `proven`.

    Raises
    ------
    OutOfTimeError
        When the time runs out before a route is found.
    """
    best = BestSoFar(graph, bounds, max(bounds.optimum, at_least))
    try:
        return _raise_threshold(problem, graph, bounds, screen, best)
    except OutOfTimeError:
        return best.unproven(problem.deadline)


def _raise_threshold(
    problem: RouteProblem, graph: StateGraph, bounds: Bounds, screen: Screening, best: BestSoFar
) -> Optimum | None:
    options = problem.options
    ceiling = problem.ceiling(graph.regions)
    # Costs of zero are possible: a least cost of zero has no relative margin.
    unit = ceiling / options.step_budget**2
    margin = options.threshold_margin
    if problem.cost.counts_x:
        offer_first_route(problem, graph, bounds, screen, best)
        if best.meets(best.excluded):
            return best.proven(best.excluded)
    cores = _Cores(problem, graph, bounds, screen, best)
    threshold = min(best.excluded + margin * max(best.excluded, unit), best.objective, ceiling)
    while True:
        core, lower = cores.below(threshold)
        if lower < threshold:
            threshold = lower
            continue
        # No route below the threshold costs less than the core's bound.
        if best.meets(least := threshold if core.empty else min(core.bound, threshold)):
            return best.proven(min(least, best.objective))
        if not core.empty:
            found = solve_core(problem, core, bounds, cores.tangents, best.sequence)
            if best.decided_by(found, core, problem.deadline):
                return best.proven(found.outcome.bound)
        if threshold >= ceiling:
            return None
        best.excluded = threshold
        margin *= _GROWTH
        threshold = min(threshold + margin * max(threshold, unit), best.objective, ceiling)


class _Cores:
    """Cores of admissible moves; the tangents found in one serve the next."""

    def __init__(
        self, problem: RouteProblem, graph: StateGraph, bounds: Bounds, screen: Screening, best: BestSoFar
    ) -> None:
        self.tangents = Tangents(graph.regions, problem.cost, bounds.prices.travel)
        self._problem = problem
        self._graph = graph
        self._bounds = bounds
        self._screen = screen
        self._best = best
        self._reach = -np.inf
        self._part = graph.moves

    def below(self, threshold: float) -> tuple[Core, float]:
        """Build the core of all routes of at most this cost, or of one that is known; also a threshold that may do.

        The core's own bound takes x and the step budget into account: a lower threshold, and a smaller core, may do.
        A large core that is not the last has moves that were not followed.
        """
        problem, graph = self._problem, self._graph
        if threshold > self._reach:
            self._reach = _AHEAD * threshold
            part = cheap_moves(graph.moves, self._bounds, self._reach)
            self._part = self._screen(_NO_MOVES, part, graph.base)
        while True:
            problem.deadline.require()
            core, route = self._expand(threshold)
            lower = core.bound * (1.0 + problem.options.threshold_margin)
            if core.empty or core.bound <= self._best.excluded or lower >= core.threshold:
                lower = threshold
            if lower < threshold and len(core.tail) > _SCREENED_EARLY:
                return core, lower
            left = self._screen(core.moves, self._part, graph.base)
            if len(left) == len(self._part):
                self._best.offer(route, core)
                return core, lower
            self._part = left

    def _expand(self, threshold: float) -> tuple[Core, StepSequence | None]:
        problem, bounds, regions = self._problem, self._bounds, self._graph.regions
        what, needed = f"a core below {threshold:.2f}", core_bytes(bounds, threshold, problem.options.step_budget)
        require_memory(problem.options, needed, what, "lower route.step_budget, or coarsen route.grid")
        core = build_core(problem, regions, self._part, bounds, threshold)
        problem.monitor.progress(
            f"route: core of {core.regions:,} regions, {len(core.tail):,} arcs, threshold {threshold:.2f}"
        )
        if core.empty or not problem.cost.counts_x:
            return core, None
        return tighten_core(problem, core, bounds, self.tangents, self._best.objective)
