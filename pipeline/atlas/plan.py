"""The best routes between pairs of stations, one after the other; what is learned of moves serves all of them."""

import time
from collections.abc import Iterator, MutableMapping, Sequence
from dataclasses import dataclass

from pipeline.atlas.graph import AtlasGraph
from pipeline.atlas.reversal import is_reversible, reversed_route
from pipeline.errors import ConfigError, NoSolutionError
from pipeline.machine.geometry import build_machine
from pipeline.progress import QUIET, Monitor
from pipeline.route.moves.screen import Screen
from pipeline.route.own_rails import on_own_rails
from pipeline.route.planner import chosen_route, screen_of, solve_problem
from pipeline.route.regions.counting import require_possible_task
from pipeline.route.result import Route
from pipeline.route.straight_ends import require_straight_ends, with_straight_ends
from pipeline.status import Status

Pair = tuple[int, int]
"""Numbers of the stations that a route begins and ends at."""

IMPOSSIBLE, FAILED = "impossible", "failed"
"""Status of a pair that is refused before any search, and of one whose search failed without a status of its own."""


@dataclass(frozen=True, eq=False)
class AtlasEntry:
    """The best route of a pair of stations, or why there is none.

    Attributes
    ----------
    pair : tuple of int
        Numbers of the stations.
    status : str
        That of the route (`Status`), "infeasible" or "impossible" where it is proven that there is none, "time limit"
        or "failed" where none was found.
    route : Route or None
        The route.
    reason, advice : str
        Why there is none, and what to change.
    from_reverse : bool
        Whether it follows from the entry of the opposite pair.
    seconds : float
        How long it took.
    """

    pair: Pair
    status: str
    route: Route | None
    reason: str = ""
    advice: str = ""
    from_reverse: bool = False
    seconds: float = 0.0


def plan_pairs(
    graph: AtlasGraph,
    pairs: Sequence[Pair],
    known: MutableMapping[Pair, AtlasEntry],
    monitor: Monitor = QUIET,
    *,
    guided: bool = True,
) -> Iterator[AtlasEntry]:
    """Find the best route of each pair, in their order; each is the one that `plan_route` finds, or one as good.

    Where reversal gives the answer to a pair, and that to the opposite pair is proven, it is not searched. Every search
    may take `route.time_limit_s`.

    Parameters
    ----------
    known : mapping
        Entries that are known already; those found are added.
    guided : bool
        Whether the routes have what guides stage two (`Search.least_kappa_max`); searches take longer.
    """
    reversible, screen = is_reversible(graph.config, build_machine(graph.config.machine)), None
    guided = guided or graph.config.route.alternative > 1
    for number, pair in enumerate(pairs):
        watched = _watched(graph, pair, number, len(pairs), monitor)
        opposite = known.get((pair[1], pair[0]))
        began = time.perf_counter()
        entry = _reversed(graph, pair, opposite, watched) if reversible and opposite is not None else None
        if entry is None:
            entry, screen = _searched(graph, pair, screen, guided, watched)
        known[pair] = _timed(entry, time.perf_counter() - began)
        yield known[pair]


def _searched(
    graph: AtlasGraph, pair: Pair, before: Screen | None, guided: bool, monitor: Monitor
) -> tuple[AtlasEntry, Screen | None]:
    """Search for the route of a pair; the moves followed for it are known to the screen that is returned."""
    config, machine = graph.pair_config(pair), build_machine(graph.config.machine)
    screen = before
    try:
        require_possible_task(config, machine)
        require_straight_ends(config, machine)
        problem = graph.problem(pair, monitor, guided=guided)
        screen = screen_of(problem)
        if before is not None:
            screen.learn(before)
        route = chosen_route(config.route, solve_problem(problem, config.route.alternative, screen))
    except ConfigError as error:
        return AtlasEntry(pair, IMPOSSIBLE, None, "; ".join(str(issue) for issue in error.issues)), screen
    except NoSolutionError as error:
        status = str(error.diagnosis.get("status", FAILED))
        return AtlasEntry(pair, status, None, error.reason, error.advice), screen
    route = on_own_rails(config, machine, with_straight_ends(config, graph.machine, route))
    return AtlasEntry(pair, str(route.status), route), screen


def _reversed(graph: AtlasGraph, pair: Pair, opposite: AtlasEntry, monitor: Monitor) -> AtlasEntry | None:
    """Give the entry of a pair that follows from what is proven of the opposite one; None if it has to be searched."""
    if opposite.status == Status.INFEASIBLE:
        reason = f"as there is none the other way round: {opposite.reason}"
        return AtlasEntry(pair, opposite.status, None, reason, opposite.advice, from_reverse=True)
    if opposite.route is None or opposite.status != Status.OPTIMAL:
        return None
    try:
        route = reversed_route(graph.problem(pair, monitor), opposite.route)
    except NoSolutionError:
        # Rounding broke a rule: a search decides.
        return None
    return None if route is None else AtlasEntry(pair, str(route.status), route, from_reverse=True)


def _timed(entry: AtlasEntry, seconds: float) -> AtlasEntry:
    return AtlasEntry(
        entry.pair, entry.status, entry.route, entry.reason, entry.advice, entry.from_reverse, round(seconds, 6)
    )


def _watched(graph: AtlasGraph, pair: Pair, number: int, count: int, monitor: Monitor) -> Monitor:
    """Let a monitor say which pair is searched, and how many are done."""
    origin, target = (graph.stations[k].name for k in pair)

    def progress(message: str, fraction: float | None = None) -> None:
        monitor.progress(f"{origin} to {target} ({number + 1} of {count}): {message}", number / count)

    return Monitor(progress, monitor.verbose)
