"""Why there is no route: how far each limit, one at a time, has to give until one exists.

The graph of a table with generous limits shows by bisection below which value the ends are not joined at all; from
there on the whole search, with x, step budget and moves followed, decides.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order

from pipeline.arrays import BoolArray, FloatArray
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.limits import Relaxation, relaxations
from pipeline.machine.geometry import Machine
from pipeline.progress import QUIET, Monitor, Progress
from pipeline.route.bounds.shortest_paths import fewest_positions
from pipeline.route.diagnosis.endpoints import end_remarks
from pipeline.route.diagnosis.relaxed_table import RelaxedTable, SearchOutcome, WholeSearch, prefixed, search_whole
from pipeline.route.diagnosis.result import Finding, InfeasibilityReport, Verdict
from pipeline.route.moves.candidates import Moves, find_moves
from pipeline.route.regions.table import RegionTable

_TRIES = 12
"""Most whole searches per limit."""
_MOST_POSITIONS = 500
_ROUNDING = 1e-9


def explain_infeasibility(
    config: Config,
    machine: Machine,
    regions: RegionTable,
    monitor: Monitor = QUIET,
    limits: Sequence[Relaxation] | None = None,
) -> InfeasibilityReport:
    """Find out what prevents a route that `plan_route` could not find on `regions`.

    Every finding is about one limit alone, all others as configured, on the same grid; `limits` are those that are
    relaxed, all by default.
    """
    progress = monitor.progress
    limits = relaxations(config, machine) if limits is None else limits
    moves = find_moves(config, machine, regions, Monitor(prefixed(progress, "as configured")))
    findings = [relax_limit(config, machine, relaxation, progress) for relaxation in limits]
    if config.route.step_budget < _MOST_POSITIONS:
        findings.append(relax_step_budget(config, machine, regions, moves, progress))
    return InfeasibilityReport(
        remarks=(*end_remarks(config, machine, regions, moves), *not_varied(config)),
        findings=tuple(findings),
        from_start=reached(moves, len(regions), regions.start),
        to_goal=reached(moves, len(regions), regions.goal, backwards=True),
    )


def not_varied(config: Config) -> list[str]:
    """List what else the task asks for that is not a limit varied here."""
    task = config.task
    asked = [f"task.budget.{key} {value:g}" for key, value in task.budget if value is not None]
    asked += [f"task.{key} ({len(many)})" for key, many in (("avoid", task.avoid), ("visit", task.visit)) if many]
    return [f"also asked for, and not varied here: {', '.join(asked)}"] if asked else []


def reached(moves: Moves, count: int, root: int, backwards: bool = False) -> BoolArray:
    """Mark the regions (count,) that can be reached from region `root`, or from which it can be reached."""
    graph = moves.graph(np.ones(count))
    found = np.zeros(count, dtype=bool)
    found[breadth_first_order(csr_array(graph.T) if backwards else graph, root, return_predecessors=False)] = True
    return found


@dataclass(frozen=True)
class FeasibilityThreshold:
    """Where in a list of values routes begin to exist, as far as it is known.

    Attributes
    ----------
    refused : int
        The last value proven not to be enough.
    by_graph : bool
        That the graph alone proves it.
    opened : int or None
        The first value a route was found with, and `objective` its sum of kappa.
    """

    refused: int
    by_graph: bool
    opened: int | None = None
    objective: float | None = None


def find_threshold(
    known: FeasibilityThreshold, first: int, end: int, attempt: Callable[[int], SearchOutcome], tries: int = _TRIES
) -> FeasibilityThreshold:
    """Find the first of the values `first` to `end` - 1 that opens: it, then the last, then by bisection.

    Each route found points at the value that is enough for it, as far as its regions go: that one is tried next.
    """
    low, threshold, candidate = first - 1, known, first
    for _ in range(tries):
        result = attempt(candidate)
        if result.objective is not None:
            threshold = replace(threshold, opened=candidate, objective=result.objective)
        else:
            low = candidate
            threshold = replace(threshold, refused=low, by_graph=False) if result.proven else threshold
        if threshold.opened is None:
            if low == end - 1:
                break
            candidate = end - 1
        elif threshold.opened - low <= 1:
            break
        elif result.enough is not None and low < result.enough < threshold.opened:
            candidate = result.enough
        else:
            candidate = (low + threshold.opened) // 2
    return threshold


def relax_limit(
    config: Config, machine: Machine, relaxation: Relaxation, progress: Progress, run: WholeSearch = search_whole
) -> Finding:
    """Relax one limit, part by part of its values, until a route exists."""
    threshold = FeasibilityThreshold(refused=0, by_graph=False)
    for begin, end in pairwise((0, *relaxation.segments)):
        try:
            wide = RelaxedTable.build(machine, relaxation, end, config.route, progress)
        except NoSolutionError:
            # A table beyond the memory allowed, or with a visit out of reach, shows nothing: what is known stays.
            break
        first = wide.first_joined(begin, end)
        if first > begin:
            threshold = FeasibilityThreshold(refused=first - 1, by_graph=True)
        if first < end:
            threshold = find_threshold(threshold, max(first, threshold.refused + 1), end, partial(wide.search, run=run))
        if threshold.opened is not None:
            break
    return _finding(relaxation.key, relaxation.configured, relaxation.levels, threshold, relaxation.locked_axes)


def _finding(
    key: str,
    configured: float,
    levels: FloatArray,
    threshold: FeasibilityThreshold,
    locked_axes: tuple[str, ...] | None = None,
) -> Finding:
    none = Verdict.NEVER if threshold.refused == len(levels) - 1 else Verdict.UNDECIDED
    return Finding(
        key=key,
        configured=configured,
        bound=float(levels[-1]),
        value=None if threshold.opened is None else float(levels[threshold.opened]),
        objective=threshold.objective,
        refused=float(levels[threshold.refused]),
        by_graph=threshold.by_graph,
        exact=threshold.opened == threshold.refused + 1,
        verdict=none if threshold.opened is None else Verdict.OPENS,
        locked_axes=locked_axes,
    )


def relax_step_budget(
    config: Config, machine: Machine, regions: RegionTable, moves: Moves, progress: Progress
) -> Finding:
    """Relax the number of positions: the graph knows the fewest, x and the moves followed may need more."""
    configured = config.route.step_budget
    fewest = least_budget(config, regions, moves)
    last = _MOST_POSITIONS if fewest is None else min(_MOST_POSITIONS, 2 * max(fewest, configured))
    levels = np.arange(configured, last + 1, dtype=float)
    if fewest is None or fewest > last:
        return _finding("route.step_budget", configured, levels, FeasibilityThreshold(len(levels) - 1, by_graph=True))

    def attempt(index: int) -> SearchOutcome:
        options = config.route.model_copy(update={"step_budget": int(levels[index])})
        changed = config.model_copy(update={"route": options})
        found, proven = search_whole(changed, machine, regions, prefixed(progress, "route.step_budget"))
        if found is None:
            return SearchOutcome(None, proven)
        return SearchOutcome(found.objective, enough=len(found) - configured)

    short = max(fewest - configured - 1, 0)
    known = FeasibilityThreshold(short, by_graph=fewest > configured)
    threshold = find_threshold(known, short + 1, len(levels), attempt)
    return _finding("route.step_budget", configured, levels, threshold)


def least_budget(config: Config, regions: RegionTable, moves: Moves) -> int | None:
    """Count the positions that no route can do with fewer of, be it for the moves or for the distance along X."""
    fewest = fewest_positions(regions, moves)
    distance_m = abs(config.task.goal.x_m - config.task.start.x_m)
    along = int(np.ceil(distance_m / config.route.x_step_m - _ROUNDING))
    return None if fewest is None else max(fewest, along + 1)
