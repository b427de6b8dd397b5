"""A good route through a core: a dynamic program over step, region and a grid of x.

It proves nothing; but where lower bounds are sharp, the regions it passes at their best x often are an optimum.
"""

import math
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.core.build import Core
from pipeline.route.metric import ROUNDING
from pipeline.route.problem import RouteProblem
from pipeline.route.regions.table import RegionTable

_MOST_STATES = 400_000_000
"""Arcs times grid points times travels: cores in which there are more are not searched."""
_BLOCK = 50_000
"""Moves times grid points at a time."""


def route_on_grid(
    problem: RouteProblem, core: Core, regions: RegionTable, prices: FloatArray, per_move: int
) -> tuple[IntArray, FloatArray] | None:
    """Find the route of least cost, and use of budgets at `prices` (budgets,), whose x are on a grid.

    The grid has at least `per_move` parts in a largest move along X; start and goal are on it. Returns rows of
    `regions` and x of every step (n,), waits included; None: there is none on the grid, or too much to search.
    """
    points = 1.0 + per_move * np.ptp(regions.x_window_m[core.region]) / core.x_step_m
    if len(core.tail) * points * (2 * per_move + 1) > _MOST_STATES:
        return None
    grid = _Grid.of(problem, core, regions, prices, per_move)
    values = [np.full(grid.inside.shape, np.inf)]
    values[0][grid.start] = 0.0
    for _ in range(core.step_budget - 1):
        values.append(grid.step(values[-1]))
    return grid.way(values) if np.isfinite(values[-1][grid.goal]) else None


@dataclass(frozen=True, eq=False)
class _Grid:
    """Moves between the regions of a core, waits included, sorted by their targets.

    Attributes
    ----------
    rows : (r,)
        Rows of the region table.
    x_m : (c,)
        Points of the grid.
    inside : (r, c)
        Which are in the window of each region.
    source, target : (m,)
        Regions moves join, numbered as `rows`.
    costs : (m, 2 shifts + 1)
        Of every move for each number of points it travels.
    start, goal : tuple
        Region and point.
    """

    rows: IntArray
    x_m: FloatArray
    inside: FloatArray
    source: IntArray
    target: IntArray
    costs: FloatArray
    start: tuple[int, int]
    goal: tuple[int, int]

    @classmethod
    def of(cls, problem: RouteProblem, core: Core, regions: RegionTable, prices: FloatArray, per_move: int) -> "_Grid":
        rows, moves = np.unique(core.region), core.moves
        waiting = np.arange(len(rows))
        source = np.append(np.searchsorted(rows, moves.source), waiting)
        target = np.append(np.searchsorted(rows, moves.target), waiting)
        order = np.argsort(target, kind="stable")
        source, target = source[order], target[order]
        low, high = regions.x_window_m[rows].T
        from_x, to_x = float(core.window_m[0, 0]), float(core.window_m[-1, 0])
        size = core.x_step_m / per_move
        if parts := math.ceil(abs(to_x - from_x) / size - ROUNDING):
            size = abs(to_x - from_x) / parts
        shifts = math.floor(core.x_step_m / size + ROUNDING)
        before, after = (math.floor(room / size + ROUNDING) for room in (from_x - low.min(), high.max() - from_x))
        x = from_x + size * np.arange(-before, after + 1)
        ends = regions, rows[source], rows[target]
        fixed = np.zeros(len(source))
        for price, budget in zip(prices.tolist(), core.budgets, strict=True):
            fixed += price * budget.used(*ends)
        per_m = float(prices @ [float(budget.travels) for budget in core.budgets])
        travels = size * np.arange(-shifts, shifts + 1)
        costs = [problem.cost.at(*ends, np.full(len(source), dx)) + fixed + per_m * abs(dx) for dx in travels.tolist()]
        return cls(
            rows=rows,
            x_m=x,
            inside=(x >= low[:, None] - ROUNDING) & (x <= high[:, None] + ROUNDING),
            source=source,
            target=target,
            costs=np.array(costs).T,
            start=(int(np.searchsorted(rows, regions.start)), before),
            goal=(int(np.searchsorted(rows, regions.goal)), before + round((to_x - from_x) / size)),
        )

    @property
    def _shifts(self) -> int:
        return int(self.costs.shape[1] // 2)

    def step(self, values: FloatArray) -> FloatArray:
        """Make one more step, from least costs (r, c)."""
        shifts, points = self._shifts, len(self.x_m)
        padded = np.pad(values, ((0, 0), (shifts, shifts)), constant_values=np.inf)
        ahead = np.full(values.shape, np.inf)
        for moves in np.array_split(np.arange(len(self.source)), -(-len(self.source) * points // _BLOCK)):
            before = padded[self.source[moves]]
            there = np.full((len(moves), points), np.inf)
            for column in range(2 * shifts + 1):
                # A travel of `column - shifts` points ends that far from where it began.
                first = 2 * shifts - column
                np.minimum(there, before[:, first : first + points] + self.costs[moves, column, None], out=there)
            begins = np.flatnonzero(np.diff(self.target[moves], prepend=-1))
            into = self.target[moves[begins]]
            ahead[into] = np.minimum(ahead[into], np.minimum.reduceat(there, begins))
        return np.where(self.inside, ahead, np.inf)

    def way(self, values: list[FloatArray]) -> tuple[IntArray, FloatArray]:
        """Follow the least costs (r, c) of every step back from the goal."""
        shifts, (region, point) = self._shifts, self.goal
        regions, points = [region], [point]
        for before in values[-2::-1]:
            begin, end = np.searchsorted(self.target, [region, region + 1])
            here = np.arange(point + shifts, point - shifts - 1, -1)
            open_ = (here >= 0) & (here < len(self.x_m))
            costs = self.costs[begin:end][:, open_] + before[self.source[begin:end, None], here[open_]]
            move, column = np.unravel_index(int(costs.argmin()), costs.shape)
            region, point = int(self.source[begin + int(move)]), int(here[open_][column])
            regions.append(region)
            points.append(point)
        way = self.rows[regions[::-1]]
        count = int(np.argmax(way == way[-1])) + 1
        return way[:count], self.x_m[points[::-1]][:count]
