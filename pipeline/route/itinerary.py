"""Itineraries: what a route must have done on its way, as a state that only moves on.

Visits must be made in their order, and an alternative must once have strayed from every better route. What has
been done is a state; regions are laid out once for each state they can be in, and a move leads to the state in
which its target leaves the route. Over regions so laid out every route from start to goal has done it all, and
nothing else in stage one needs to know.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.machine.geometry import BoolArray, FloatArray, IntArray
from pipeline.route.grid import gate_bit
from pipeline.route.moves import Moves
from pipeline.route.table import RegionTable

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Layout:
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


def plain_layout(regions: RegionTable, moves: Moves) -> Layout:
    """Lay every region out once: nothing is asked of the way."""
    return Layout(np.arange(len(regions)), regions, moves)


def lay_out(regions: RegionTable, moves: Moves, near: BoolArray) -> Layout:
    """Lay out regions by visits made and better routes strayed from.

    Parameters
    ----------
    near : (routes, n)
        Which regions are near each better route: being elsewhere is straying from it.
    """
    visits = int(regions.visit.max(initial=0))
    if visits == 0 and len(near) == 0:
        return plain_layout(regions, moves)
    strayed = ((~near).T @ (1 << np.arange(len(near)))).astype(np.int64)
    states = (visits + 1) << len(near)
    arrival = np.stack([_arrive(state, regions.visit, strayed, visits, len(near)) for state in range(states)])
    # A region is laid out in a state when arriving there leaves the state as it is; start and goal once each.
    present = arrival == np.arange(states)[:, None]
    present[:, [regions.start, regions.goal]] = False
    present[arrival[0, regions.start], regions.start] = True
    present[states - 1, regions.goal] = True
    number = np.cumsum(present.ravel()).reshape(present.shape) - 1
    base = np.nonzero(present)[1]
    sources, targets = [], []
    for here in range(states):
        use = np.flatnonzero(present[here, moves.source])
        source, target = moves.source[use], moves.target[use]
        there = arrival[here, target]
        use = np.flatnonzero(present[there, target])
        sources.append(number[here, source[use]])
        targets.append(number[there[use], target[use]])
    return _ends_last(regions, base, np.concatenate(sources), np.concatenate(targets))


def _arrive(state: int, visit: IntArray, strayed: IntArray, visits: int, routes: int) -> IntArray:
    """State after arriving at each region (n,) in a state: number of visits made, then a bit per route strayed from."""
    made, bits = state >> routes, state & ((1 << routes) - 1)
    made_there = np.where(visit == made + 1, made + 1, made)
    arrived: IntArray = (made_there << routes) | bits | strayed
    return arrived


def _ends_last(regions: RegionTable, base: IntArray, source: IntArray, target: IntArray) -> Layout:
    """Bring start and goal to the end, and the moves into the order of their sources."""
    end = np.isin(base, [regions.start, regions.goal])
    order = np.concatenate(
        [np.flatnonzero(~end), *(np.flatnonzero(base == row) for row in (regions.start, regions.goal))]
    )
    place = np.empty(len(base), dtype=np.int32)
    place[order] = np.arange(len(order))
    source, target = place[source], place[target]
    order_of_moves = np.argsort(source, kind="stable")
    return Layout(base[order], regions.take(base[order]), Moves(source[order_of_moves], target[order_of_moves]))


def near_route(regions: RegionTable, steps: FloatArray, rows: IntArray, distance: float) -> BoolArray:
    """Tell which regions are within `distance` grid steps of a step of a route in the same working mode. Shape (n,).

    At a gate either working mode of its arm will do. x is left out; `rows` (k,) are the route's regions.
    """
    scaled = regions.controlled[:, 1:] / steps[1:]
    free = gate_bit(regions.gate)
    near = np.zeros(len(regions), dtype=bool)
    for row in rows.tolist():
        apart = np.abs(scaled - scaled[row]).max(axis=1) <= distance + _ROUNDING
        near |= apart & (((regions.mode ^ regions.mode[row]) & ~(free | free[row])) == 0)
    return near
