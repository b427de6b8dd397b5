"""The least sum of kappa over the admitted moves, by cores or by a program over all regions at a time.

The core holds every route of cost at most a threshold, so that its optimum is the optimum when it is at most
the threshold. The threshold starts just above the best bound and is raised until that is so: exact always.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pipeline.arrays import IntArray
from pipeline.progress import Monitor
from pipeline.route.bounds.shortest_paths import Bounds, cheap_moves
from pipeline.route.cost import region_costs
from pipeline.route.deadline import Deadline, OutOfTimeError
from pipeline.route.memory import require_memory
from pipeline.route.metric import ROUNDING
from pipeline.route.moves.candidates import Moves
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.core import Core, build_core, core_bytes
from pipeline.route.programs.core_program import build_core_program, read_core
from pipeline.route.programs.exclusions import excluded_pairs
from pipeline.route.programs.solution import StepSequence, solve_steps
from pipeline.route.programs.whole import WHOLE_PROGRAMS
from pipeline.route.search.label_setting import WIDTH, solve_labels
from pipeline.route.search.states import StateGraph
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
class Optimum:
    """The best sequence found over the moves admitted so far, with what is proven of it.

    Attributes
    ----------
    sequence : StepSequence
        Rows of the region table, and x, of the steps.
    threshold : float
        T of the core it was found on; infinite for a program over all regions.
    regions : int
        Number of regions of the program.
    relaxation : float
        Bound on the sum of kappa when x and the step budget are left out.
    bound : float
        Proven lower bound on the sum of kappa.
    proven : bool
        That it is the optimum; otherwise the time ran out.
    cap : float
        Cap on kappa: the least that leaves a route where the largest kappa counts, infinite where only the sum does.
    """

    sequence: StepSequence
    threshold: float
    regions: int
    relaxation: float
    bound: float
    proven: bool = True
    cap: float = np.inf

    @property
    def objective(self) -> float:
        """The sum of kappa, as the solver gives it."""
        return self.sequence.outcome.objective


def find_optimum(
    problem: RouteProblem,
    graph: StateGraph,
    bounds: Bounds,
    at_least: float = 0.0,
    screen: Screening = keep_all,
) -> Optimum | None:
    """Find the route of least sum of kappa with the configured formulation; None: there is no route (proven).

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
        sequence=_in_table(found, graph),
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
    best = _BestSoFar(
        graph, bounds, max(bounds.optimum, at_least, float(region_costs(graph.regions)[graph.regions.start]))
    )
    try:
        return _raise_threshold(problem, graph, bounds, screen, best)
    except OutOfTimeError:
        return best.unproven(problem.deadline)


def _raise_threshold(
    problem: RouteProblem, graph: StateGraph, bounds: Bounds, screen: Screening, best: "_BestSoFar"
) -> Optimum | None:
    options, regions, moves = problem.options, graph.regions, graph.moves
    # No route within the step budget can cost more than this.
    ceiling = options.step_budget * float(regions.kappa.max())
    margin = options.threshold_margin
    threshold, reach, part = min(best.excluded * (1.0 + margin), ceiling), -np.inf, moves
    while True:
        problem.deadline.require()
        if threshold > reach:
            reach = _AHEAD * threshold
            part = screen(_NO_MOVES, cheap_moves(moves, bounds, reach), graph.base)
        what, needed = f"a core below {threshold:.2f}", core_bytes(bounds, threshold, options.step_budget)
        require_memory(options, needed, what, "lower route.step_budget, or coarsen route.grid")
        core = build_core(regions, part, bounds, threshold, options.step_budget, options.x_step_m)
        problem.monitor.progress(
            f"route: core of {core.regions:,} regions, {len(core.tail):,} arcs, threshold {threshold:.2f}"
        )
        # The core's own bound takes x and the step budget into account: a lower threshold, and a smaller core, may do.
        lower = core.bound * (1.0 + options.threshold_margin)
        lowered = not core.empty and core.bound > best.excluded and lower < min(threshold, best.objective)
        if not lowered or len(core.tail) <= _SCREENED_EARLY:
            left = screen(core.moves, part, graph.base)
            if len(left) < len(part):
                part = left
                continue
        if lowered:
            threshold, margin = lower, options.threshold_margin
            continue
        if not core.empty:
            found = solve_core(core, bounds, problem.deadline, problem.monitor)
            if best.decided_by(found, core, problem.deadline):
                return best.proven(found.outcome.bound)
        if threshold >= ceiling:
            return None
        best.excluded = threshold
        margin *= _GROWTH
        threshold = min(threshold * (1.0 + margin), best.objective, ceiling)


class _BestSoFar:
    """The least costly sequence found on the cores solved so far, whatever their thresholds.

    Attributes
    ----------
    excluded : float
        No route is less costly (proven).
    """

    def __init__(self, graph: StateGraph, bounds: Bounds, excluded: float) -> None:
        self.excluded = excluded
        self._graph = graph
        self._bounds = bounds
        self._found: tuple[StepSequence, Core] | None = None

    @property
    def objective(self) -> float:
        """Its cost, infinite without one."""
        return self._found[0].outcome.objective if self._found else np.inf

    def decided_by(self, sequence: StepSequence, core: Core, deadline: Deadline) -> bool:
        """Take over the outcome of a core; return whether it is the optimum.

        Raises
        ------
        OutOfTimeError
            When the time ran out before that was proven.
        """
        outcome = sequence.outcome
        # Of equal ones the last is taken, whose core may prove it.
        if len(sequence.region) and outcome.objective <= self.objective * (1.0 + ROUNDING):
            self._found = (sequence, core)
        if outcome.status not in (Status.OPTIMAL, Status.INFEASIBLE):
            self.excluded = max(self.excluded, min(outcome.bound, core.threshold))
            raise deadline.error(self.excluded)
        return outcome.objective <= core.threshold * (1.0 + ROUNDING)

    def proven(self, bound: float) -> Optimum:
        """Give it as the optimum."""
        assert self._found is not None
        sequence, core = self._found
        return Optimum(_in_table(sequence, self._graph), core.threshold, core.regions, self._bounds.optimum, bound)

    def unproven(self, deadline: Deadline) -> Optimum:
        """Give it as what was found in time, with the bound proven by then.

        Raises
        ------
        OutOfTimeError
            When nothing was found.
        """
        if self._found is None:
            raise deadline.error(self.excluded)
        return replace(self.proven(min(self.excluded, self.objective)), proven=False)


def solve_core(core: Core, bounds: Bounds, deadline: Deadline, monitor: Monitor) -> StepSequence:
    """Find the optimum over a core that is not empty: by label setting where there are budgets, else by HiGHS.

    Budgets that are almost used up make the relaxations of a mixed-integer program weak and its incumbents rare; labels
    are then few. Should they be too many after all, HiGHS decides.
    """
    prices, monitor, some = np.array(bounds.prices.prices), deadline.shown(monitor), None
    if core.budgets:
        monitor.progress("label setting")
        some = solve_labels(core, prices, deadline, width=WIDTH)
        found = solve_labels(core, prices, deadline, min(some.outcome.objective, core.threshold))
        if found.outcome.status is Status.OPTIMAL:
            return found
        if found.outcome.status is Status.INFEASIBLE:
            # Nothing within the threshold; what costs more says how far to raise it.
            return replace(some, outcome=replace(some.outcome, status=Status.INFEASIBLE))
    found = solve_steps(build_core_program(core), partial(read_core, core=core), deadline.left_s, monitor)
    if found.outcome.status in (Status.OPTIMAL, Status.INFEASIBLE):
        return found
    some = solve_labels(core, prices, deadline, width=WIDTH) if some is None else some
    better = found if found.outcome.objective <= some.outcome.objective else some
    bound = max(found.outcome.bound, some.outcome.bound)
    return replace(better, outcome=replace(better.outcome, status=found.outcome.status, bound=bound))


def _in_table(sequence: StepSequence, graph: StateGraph) -> StepSequence:
    """Give a sequence of the graph in rows of the region table."""
    return replace(sequence, region=graph.base[sequence.region])
