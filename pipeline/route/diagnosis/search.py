"""Why there is no route: how far each limit, one at a time, has to give until one exists.

The graph of a table with generous limits tells by bisection below which value there is no way at all; from
there on the whole search, x, step budget and moves followed included, decides.
"""

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import Config, RouteConfig
from pipeline.errors import InfeasibleError, NoSolutionError
from pipeline.machine.geometry import Machine, build_machine
from pipeline.progress import Monitor, Progress, silent
from pipeline.route.bounds.shortest_paths import fewest_positions
from pipeline.route.diagnosis.endpoints import end_remarks
from pipeline.route.diagnosis.relaxable_limits import RegionFilter, RelaxableLimit, not_varied, relaxable_limits
from pipeline.route.diagnosis.result import Finding, InfeasibilityReport, Verdict
from pipeline.route.moves.candidates import Moves, find_moves
from pipeline.route.planner import plan_route
from pipeline.route.regions.build import build_regions
from pipeline.route.regions.table import RegionTable
from pipeline.route.result import Route

_TRIES = 12
"""Most whole searches per limit."""
_SEARCH_ROUNDS, _SEARCH_S = 30, 30.0
"""Most rounds of such a search, and the time limit of each of its solves."""
_MOST_POSITIONS = 500
_ROUNDING = 1e-9


def explain_infeasibility(
    config: Config, machine: Machine, regions: RegionTable, progress: Progress = silent
) -> InfeasibilityReport:
    """Find out what stands in the way of a route that `plan_route` could not find on `regions`.

    Every finding is about one limit alone, all others as configured, on the same grid.
    """
    moves = find_moves(config, machine, regions, telling(progress, "as configured"))
    findings = [relax_limit(config, obstacle, progress) for obstacle in relaxable_limits(config, machine)]
    if config.route.step_budget < _MOST_POSITIONS:
        findings.append(_step_budget(config, machine, regions, moves, progress))
    return InfeasibilityReport(
        remarks=(*end_remarks(config, machine, regions, moves), *not_varied(config)),
        findings=tuple(findings),
        from_start=reached(moves, len(regions), regions.start),
        to_goal=reached(moves, len(regions), regions.goal, backwards=True),
    )


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


@dataclass(frozen=True)
class SearchOutcome:
    """How a whole search ended.

    Attributes
    ----------
    objective : float or None
        The sum of kappa of the route found, None for none.
    proven : bool
        That there is none.
    enough : int or None
        The first value that admits all regions of the route found.
    """

    objective: float | None
    proven: bool = True
    enough: int | None = None


def find_threshold(
    known: FeasibilityThreshold, first: int, end: int, attempt: Callable[[int], SearchOutcome], tries: int = _TRIES
) -> FeasibilityThreshold:
    """Find the first of the values `first` to `end` - 1 that opens: it, then the last, then by bisection.

    Each route found points at the value that is enough for it, as far as its regions go: that one is tried next.
    """
    low, edge, candidate = first - 1, known, first
    for _ in range(tries):
        result = attempt(candidate)
        if result.objective is not None:
            edge = replace(edge, opened=candidate, objective=result.objective)
        else:
            low = candidate
            edge = replace(edge, refused=low, by_graph=False) if result.proven else edge
        if edge.opened is None:
            if low == end - 1:
                break
            candidate = end - 1
        elif edge.opened - low <= 1:
            break
        elif result.enough is not None and low < result.enough < edge.opened:
            candidate = result.enough
        else:
            candidate = (low + edge.opened) // 2
    return edge


def relax_limit(config: Config, obstacle: RelaxableLimit, progress: Progress) -> Finding:
    """Look at one limit, part by part of its values."""
    edge = FeasibilityThreshold(refused=0, by_graph=False)
    for begin, end in pairwise((0, *obstacle.segments)):
        try:
            wide = _Wide.build(config, obstacle, end, progress)
        except NoSolutionError:
            # A table beyond the memory allowed, or with a visit out of reach, tells nothing: what is known stays.
            break
        first = wide.first_way(begin, end)
        if first > begin:
            edge = FeasibilityThreshold(refused=first - 1, by_graph=True)
        if first < end:
            edge = find_threshold(edge, max(first, edge.refused + 1), end, wide.search)
        if edge.opened is not None:
            break
    return _finding(obstacle.key, obstacle.configured, obstacle.levels, edge, obstacle.locked_axes)


def _finding(
    key: str,
    configured: float,
    levels: FloatArray,
    edge: FeasibilityThreshold,
    locked_axes: tuple[str, ...] | None = None,
) -> Finding:
    none = Verdict.NEVER if edge.refused == len(levels) - 1 else Verdict.UNDECIDED
    return Finding(
        key=key,
        configured=configured,
        bound=float(levels[-1]),
        value=None if edge.opened is None else float(levels[edge.opened]),
        objective=edge.objective,
        refused=float(levels[edge.refused]),
        by_graph=edge.by_graph,
        exact=edge.opened == edge.refused + 1,
        verdict=none if edge.opened is None else Verdict.OPENS,
        locked_axes=locked_axes,
    )


@dataclass(frozen=True, eq=False)
class _Wide:
    """The table and the moves of a generous value of a limit, to be cut down to others."""

    obstacle: RelaxableLimit
    regions: RegionTable
    moves: Moves
    cut: RegionFilter
    options: RouteConfig
    progress: Progress

    @classmethod
    def build(cls, config: Config, obstacle: RelaxableLimit, end: int, progress: Progress) -> "_Wide":
        """Build them for the mildest of the first `end` values."""
        value = float(obstacle.levels[end - 1])

        tell = telling(progress, f"{obstacle.key} {value:g}")
        wide = obstacle.change(value)
        machine = build_machine(wide.machine)
        regions = build_regions(wide, machine, tell)
        moves = find_moves(wide, machine, regions, tell)
        return cls(obstacle, regions, moves, obstacle.prepare(regions), config.route, tell)

    def first_way(self, begin: int, end: int) -> int:
        """Bisect for the first of the values `begin` to `end` - 1 whose graph joins the ends; `end`: none."""
        if not self.joined(end - 1):
            return end
        return bisect_left(range(end - 1), True, lo=begin, key=self.joined)

    def joined(self, index: int) -> bool:
        """Tell whether a value lets the graph join start and goal within the step budget."""
        regions, inside = self.cut(float(self.obstacle.levels[index]))
        i, j = self.moves.source, self.moves.target
        keep = inside[i] & inside[j]
        if regions is not self.regions:
            low, high = regions.x_window_m.T
            keep &= np.maximum(low[i] - high[j], low[j] - high[i]) <= self.options.x_step_m + _ROUNDING
        fewest = fewest_positions(regions, Moves(i[keep], j[keep]))
        return fewest is not None and fewest <= self.options.step_budget

    def search(self, index: int) -> SearchOutcome:
        """Search for a route with a value."""
        value = float(self.obstacle.levels[index])
        config = self.obstacle.change(value)
        regions, inside = self.cut(value)
        rows = np.flatnonzero(inside)
        found, proven = search_whole(config, build_machine(config.machine), regions.take(rows), self.progress)
        if found is None:
            return SearchOutcome(None, proven)
        enough = bisect_left(range(index), True, key=lambda i: bool(self._admits(i, rows[found.region])))
        return SearchOutcome(found.objective, enough=enough)

    def _admits(self, index: int, rows: IntArray) -> bool:
        return bool(self.cut(float(self.obstacle.levels[index]))[1][rows].all())


def search_whole(
    config: Config, machine: Machine, regions: RegionTable, progress: Progress
) -> tuple[Route | None, bool]:
    """Run `plan_route` with little patience; also tell whether a missing route is proven not to exist."""
    options = config.route
    patience = {
        "formulation": "core",
        "objective": "sum",
        "alternative": 1,
        "max_rounds": min(_SEARCH_ROUNDS, options.max_rounds),
        "time_limit_s": min(_SEARCH_S, options.time_limit_s),
    }
    hasty = config.model_copy(update={"route": options.model_copy(update=patience)})
    try:
        return plan_route(hasty, machine, regions, Monitor(progress)), True
    except NoSolutionError as error:
        return None, isinstance(error, InfeasibleError)


def _step_budget(config: Config, machine: Machine, regions: RegionTable, moves: Moves, progress: Progress) -> Finding:
    """Look at the number of positions: the graph knows the fewest, x and the moves followed may ask for more."""
    configured = config.route.step_budget
    fewest = _least_budget(config, regions, moves)
    last = _MOST_POSITIONS if fewest is None else min(_MOST_POSITIONS, 2 * max(fewest, configured))
    levels = np.arange(configured, last + 1, dtype=float)
    if fewest is None or fewest > last:
        return _finding("route.step_budget", configured, levels, FeasibilityThreshold(len(levels) - 1, by_graph=True))

    def attempt(index: int) -> SearchOutcome:
        options = config.route.model_copy(update={"step_budget": int(levels[index])})
        changed = config.model_copy(update={"route": options})
        found, proven = search_whole(changed, machine, regions, telling(progress, "route.step_budget"))
        return (
            SearchOutcome(None, proven)
            if found is None
            else SearchOutcome(found.objective, enough=len(found) - configured)
        )

    short = max(fewest - configured - 1, 0)
    edge = find_threshold(FeasibilityThreshold(short, by_graph=fewest > configured), short + 1, len(levels), attempt)
    return _finding("route.step_budget", configured, levels, edge)


def _least_budget(config: Config, regions: RegionTable, moves: Moves) -> int | None:
    """Count the positions that no route can do with fewer of, be it for the moves or for the way along X."""
    fewest = fewest_positions(regions, moves)
    way_m = abs(config.task.goal.x_m - config.task.start.x_m)
    along = int(np.ceil(way_m / config.route.x_step_m - _ROUNDING))
    return None if fewest is None else max(fewest, along + 1)


def telling(progress: Progress, what: str) -> Progress:
    """Put in front of every message what is being looked at."""

    def tell(message: str, fraction: float | None = None) -> None:
        progress(f"why not: {what}, {message}", fraction)

    return tell
