"""Itineraries: what a route has done so far, as a state that only ever advances.

Visits must be made in their order, and an alternative must at some point stray from every better route. What has
been done is a state: the graph has a copy of each region for every state a route can be in there, and a move leads
to the copy for the state in which its target leaves the route. In the graph so expanded every route from start to
goal has done everything asked of it, and nothing else in stage one needs to know.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import RouteConfig
from pipeline.route.memory import memory_gb, require_memory
from pipeline.route.metric import ROUNDING
from pipeline.route.moves.candidates import Moves
from pipeline.route.regions.gates import gate_bit
from pipeline.route.regions.table import RegionTable


@dataclass(frozen=True, eq=False)
class StateGraph:
    """Regions expanded by state, and the moves between them.

    Attributes
    ----------
    base : (n,)
        Row of the region table that each row of `regions` is a copy of.
    regions : RegionTable
        A row per region and state; start and goal last.
    moves : Moves
        Between rows of `regions`.
    """

    base: IntArray
    regions: RegionTable
    moves: Moves


def unexpanded_graph(regions: RegionTable, moves: Moves) -> StateGraph:
    """Make the graph of a route of which no visit and no straying is asked: every region is there once."""
    return StateGraph(np.arange(len(regions)), regions, moves)


def expand_states(
    regions: RegionTable, moves: Moves, near: BoolArray, options: RouteConfig | None = None
) -> StateGraph:
    """Expand regions and moves by visits made and better routes strayed from.

    Parameters
    ----------
    near : (routes, n)
        Which regions are near each better route: a route strays from it in any other region.
    options : RouteConfig, optional
        How much memory the graph may take up; by default any.

    Raises
    ------
    NoSolutionError
        When it would take up more than `route.memory_gb`.
    """
    visits = int(regions.visits.max(initial=0))
    if visits == 0 and len(near) == 0:
        return unexpanded_graph(regions, moves)
    states = _States.of(regions, near)
    # Start and goal have one row each, the last two.
    inner = states.rows(len(regions) - 2)
    if options is not None:
        _require_memory(options, regions, moves, sum(len(rows) for rows in inner))
    first, last = int(states.after(0, np.array([regions.start]))[0]), len(inner) - 1
    parts = [*enumerate(inner), (first, np.array([regions.start])), (last, np.array([regions.goal]))]
    number = _Numbers.of(states, inner, first)
    pointer = np.searchsorted(moves.source, np.arange(len(regions) + 1))
    sources, targets, before = [], [], 0
    for state, rows in parts:
        counts = pointer[rows + 1] - pointer[rows]
        target = moves.target[_ranges(pointer[rows], counts)]
        found = number.at(states.after(state, target), target)
        there = found >= 0
        sources.append(np.repeat(np.arange(before, before + len(rows), dtype=np.int32), counts)[there])
        targets.append(found[there])
        before += len(rows)
    base = np.concatenate([rows for _, rows in parts])
    return StateGraph(base, regions.take(base), Moves(np.concatenate(sources), np.concatenate(targets)))


def _require_memory(options: RouteConfig, regions: RegionTable, moves: Moves, rows: int) -> None:
    expected = len(moves) * rows / len(regions)
    needed = memory_gb(len(regions), len(moves)) + memory_gb(rows, expected)
    what = f"{rows:,} regions and {expected:,.0f} moves, repeated for visits made and better routes strayed from,"
    advice = "leave out some of task.visit, lower route.alternative, or coarsen route.grid"
    require_memory(options, 1e9 * needed, what, advice)


@dataclass(frozen=True, eq=False)
class _States:
    """How regions (n,) change the state of a route: its visits made, then a bit per better route strayed from."""

    visit: IntArray
    strayed: IntArray
    visits: int
    routes: int

    @classmethod
    def of(cls, regions: RegionTable, near: BoolArray) -> "_States":
        strayed = np.zeros(len(regions), dtype=np.int32)
        for route, close in enumerate(near):
            strayed |= (~close).astype(np.int32) << route
        return cls(regions.visits.astype(np.int32), strayed, int(regions.visits.max(initial=0)), len(near))

    @property
    def far(self) -> int:
        """All bits: strayed from every better route."""
        return (1 << self.routes) - 1

    def after(self, state: int, rows: IntArray) -> IntArray:
        """Compute the state after arriving at each of the regions `rows` (k,) in a state."""
        made = state >> self.routes
        visited = (self.visit[rows] == made + 1).astype(np.int32)
        return np.asarray((visited << self.routes) + (self.strayed[rows] | np.int32(state)))

    def rows(self, count: int) -> list[IntArray]:
        """List those of the first `count` regions that are in each state: arriving there leaves the state as it is.

        Regions near no better route, which most are, can only be in the states that have strayed from all.
        """
        every, near = np.arange(count), np.flatnonzero(self.strayed[:count] != self.far)
        candidates = [
            every if state & self.far == self.far else near for state in range((self.visits + 1) << self.routes)
        ]
        return [rows[self.after(state, rows) == state] for state, rows in enumerate(candidates)]


@dataclass(frozen=True, eq=False)
class _Numbers:
    """Rows of the graph by state and region (n): a table for states that have strayed from all routes, else keys."""

    states: _States
    table: IntArray
    keys: IntArray
    first: int

    @classmethod
    def of(cls, states: _States, inner: list[IntArray], first: int) -> "_Numbers":
        n = len(states.visit)
        table = np.full((states.visits + 1, n), -1, dtype=np.int32)
        before = 0
        for state, rows in enumerate(inner):
            if state & states.far == states.far:
                table[state >> states.routes, rows] = np.arange(before, before + len(rows))
            before += len(rows)
        return cls(states, table, np.concatenate([state * n + rows for state, rows in enumerate(inner)]), first)

    def at(self, state: IntArray, region: IntArray) -> IntArray:
        """Look up the row of the graph for each state and region (k,), -1 where there is none.

        The ends are in one state each: the start in the first, the goal in the last.
        """
        n, routes, far = len(self.states.visit), self.states.routes, self.states.far
        number = np.asarray(self.table[state >> routes, region])
        sparse = np.flatnonzero(state & far != far)
        number[sparse] = np.searchsorted(self.keys, state[sparse] * np.int64(n) + region[sparse])
        for place, (row, its) in enumerate(((n - 2, self.first), (n - 1, ((self.states.visits + 1) << routes) - 1))):
            ends = np.flatnonzero(region == row)
            number[ends] = np.where(state[ends] == its, len(self.keys) + place, -1)
        return number


def _ranges(first: IntArray, counts: IntArray) -> IntArray:
    """Concatenate the ranges that begin at each of `first` (k,) and have `counts` (k,) numbers."""
    ranges = np.repeat(first - np.cumsum(counts) + counts, counts)
    ranges += np.arange(len(ranges))
    return ranges


def near_route(regions: RegionTable, steps: FloatArray, rows: IntArray, distance: float) -> BoolArray:
    """Mark the regions within `distance` grid steps of a region of a route, in the same working mode. Shape (n,).

    At a gate either working mode of its arm counts as the same. x does not count; `rows` (k,) are the route's regions.
    """
    scaled = regions.controlled[:, 1:] / steps[1:]
    free = gate_bit(regions.gates)
    near = np.zeros(len(regions), dtype=bool)
    for row in rows.tolist():
        apart = np.abs(scaled - scaled[row]).max(axis=1) <= distance + ROUNDING
        near |= apart & (((regions.modes ^ regions.modes[row]) & ~(free | free[row])) == 0)
    return near
