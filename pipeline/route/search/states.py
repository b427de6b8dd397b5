"""Itineraries: what a route must have done on its way, as a state that only moves on.

Visits must be made in their order, and an alternative must once have strayed from every better route. What has
been done is a state; regions are laid out once for each state they can be in, and a move leads to the state in
which its target leaves the route. Over regions so laid out every route from start to goal has done it all, and
nothing else in stage one needs to know.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.route.moves.candidates import Moves
from pipeline.route.regions.grid import gate_bit
from pipeline.route.regions.table import RegionTable

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class StateGraph:
    """Regions laid out by state, and the moves between them.

    Attributes
    ----------
    base : (n,)
        Row of the region table that each row of `regions` is.
    regions : RegionTable
        A row per region and state; start and goal last.
    moves : Moves
        Between rows of `regions`.
    """

    base: IntArray
    regions: RegionTable
    moves: Moves


def unexpanded_graph(regions: RegionTable, moves: Moves) -> StateGraph:
    """Lay every region out once: nothing is asked of the way."""
    return StateGraph(np.arange(len(regions)), regions, moves)


def expand_states(regions: RegionTable, moves: Moves, near: BoolArray) -> StateGraph:
    """Lay out regions by visits made and better routes strayed from.

    Parameters
    ----------
    near : (routes, n)
        Which regions are near each better route: being elsewhere is straying from it.
    """
    visits = int(regions.visits.max(initial=0))
    if visits == 0 and len(near) == 0:
        return unexpanded_graph(regions, moves)
    states = _States.of(regions, near)
    # Start and goal are there once each, at the end.
    inner = states.rows(len(regions) - 2)
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


@dataclass(frozen=True, eq=False)
class _States:
    """What regions (n,) do to the state of a route: its visits made, then a bit per better route strayed from."""

    visit: IntArray
    strayed: IntArray
    visits: int
    routes: int

    @classmethod
    def of(cls, regions: RegionTable, near: BoolArray) -> "_States":
        strayed = np.zeros(len(regions), dtype=np.int32)
        for route, beside in enumerate(near):
            strayed |= (~beside).astype(np.int32) << route
        return cls(regions.visits.astype(np.int32), strayed, int(regions.visits.max(initial=0)), len(near))

    @property
    def far(self) -> int:
        """All bits: strayed from every better route."""
        return (1 << self.routes) - 1

    def after(self, state: int, rows: IntArray) -> IntArray:
        """State after arriving at each of the regions `rows` (k,) in a state."""
        made = state >> self.routes
        visited = (self.visit[rows] == made + 1).astype(np.int32)
        arrived: IntArray = (visited << self.routes) + (self.strayed[rows] | np.int32(state))
        return arrived

    def rows(self, count: int) -> list[IntArray]:
        """Of the first `count` regions those laid out in each state: arriving there leaves the state as it is.

        What is near no better route, most of all regions, is looked at only where all have been strayed from.
        """
        every, near = np.arange(count), np.flatnonzero(self.strayed[:count] != self.far)
        asked = [every if state & self.far == self.far else near for state in range((self.visits + 1) << self.routes)]
        return [rows[self.after(state, rows) == state] for state, rows in enumerate(asked)]


@dataclass(frozen=True, eq=False)
class _Numbers:
    """Rows of the layout by state and region (n): a table where all routes have been strayed from, else sorted keys."""

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
        """Row of the layout for each state and region (k,), -1 where there is none: of the ends in all but one."""
        n, routes, far = len(self.states.visit), self.states.routes, self.states.far
        number: IntArray = self.table[state >> routes, region]
        sparse = np.flatnonzero(state & far != far)
        number[sparse] = np.searchsorted(self.keys, state[sparse] * np.int64(n) + region[sparse])
        for place, (row, its) in enumerate(((n - 2, self.first), (n - 1, ((self.states.visits + 1) << routes) - 1))):
            ends = np.flatnonzero(region == row)
            number[ends] = np.where(state[ends] == its, len(self.keys) + place, -1)
        return number


def _ranges(first: IntArray, counts: IntArray) -> IntArray:
    """Put the ranges from each of `first` (k,), of `counts` (k,) numbers, one behind the other."""
    ranges: IntArray = np.repeat(first - np.cumsum(counts) + counts, counts)
    ranges += np.arange(len(ranges))
    return ranges


def near_route(regions: RegionTable, steps: FloatArray, rows: IntArray, distance: float) -> BoolArray:
    """Tell which regions are within `distance` grid steps of a step of a route in the same working mode. Shape (n,).

    At a gate either working mode of its arm will do. x is left out; `rows` (k,) are the route's regions.
    """
    scaled = regions.controlled[:, 1:] / steps[1:]
    free = gate_bit(regions.gates)
    near = np.zeros(len(regions), dtype=bool)
    for row in rows.tolist():
        apart = np.abs(scaled - scaled[row]).max(axis=1) <= distance + _ROUNDING
        near |= apart & (((regions.modes ^ regions.modes[row]) & ~(free | free[row])) == 0)
    return near
