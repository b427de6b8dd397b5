"""A good route before the optimum: a beam search over the nodes of a core and some x at each.

Labels of a step are continued along all arcs, at some travels along X; the best by cost and least cost to go, both at
the prices of the bounds, are kept. It proves nothing, but ends soon: its route caps the threshold, and is what a search
has to show when the time is up.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.bounds.shortest_paths import Bounds
from pipeline.route.metric import ROUNDING
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.core import Core
from pipeline.route.regions.table import RegionTable

_WIDTH = 600
"""Labels kept per step."""
_TRAVELS = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
"""Travels of a move tried, in largest moves; windows cut them."""
_WAITS = np.array([-8.0, -4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0, 8.0])
"""Travels by waits before a move, in largest moves."""


@dataclass(frozen=True, eq=False)
class _Labels:
    """Labels (n,) of one step: on arriving at a node, or, with the label they wait from as `parent`, on leaving it.

    Attributes
    ----------
    node, parent : (n,)
        Node of the core, and label before.
    x_m, cost : (n,)
    used : (budgets, n)
        Of the budgets, travel along X included.
    waits : (n,)
        Waits so far.
    """

    node: IntArray
    parent: IntArray
    x_m: FloatArray
    cost: FloatArray
    used: FloatArray
    waits: FloatArray

    def take(self, rows: IntArray) -> "_Labels":
        return _Labels(
            self.node[rows], self.parent[rows], self.x_m[rows], self.cost[rows], self.used[:, rows], self.waits[rows]
        )


def beam_route(
    problem: RouteProblem, core: Core, bounds: Bounds, regions: RegionTable
) -> tuple[IntArray, FloatArray] | None:
    """Search a core that is not empty for a route; rows of `regions` and x of its steps. Shapes (n,)."""
    order = np.argsort(core.tail, kind="stable")
    pointer = np.searchsorted(core.tail[order], np.arange(len(core.step) + 1))
    beam = _Beam(problem, core, bounds, regions, order, pointer)
    nothing = np.zeros(1, dtype=np.int64)
    labels = _Labels(nothing, nothing, core.window_m[:1, 0], np.zeros(1), np.zeros((len(core.budgets), 1)), np.zeros(1))
    steps = [(labels, labels)]
    for step in range(core.step_budget - 1):
        if problem.deadline.passed:
            return None
        leaving = beam.wait(steps[-1][0], step)
        steps[-1] = steps[-1][0], leaving
        arriving = beam.move(leaving, step)
        if len(arriving.node) == 0:
            return None
        steps.append((arriving, arriving))
    return _read(core, steps)


@dataclass(frozen=True, eq=False)
class _Beam:
    """What continues labels; arcs of the core in the order of their tails, and where those of each node begin."""

    problem: RouteProblem
    core: Core
    bounds: Bounds
    regions: RegionTable
    order: IntArray
    pointer: IntArray

    def wait(self, labels: _Labels, step: int) -> _Labels:
        """Let labels travel where they are, but at the goal. Those that stay stay."""
        core, step_m = self.core, self.core.x_step_m
        row = np.repeat(np.arange(len(labels.node)), len(_WAITS))
        region = core.region[labels.node[row]]
        x = labels.x_m[row]
        low, high = self.regions.x_window_m[region].T
        there = np.clip(x + np.tile(_WAITS * step_m, len(labels.node)), low, high)
        there = np.where(region == self.regions.goal, x, there)
        way = np.abs(there - x)
        before = labels.take(row)
        cost = before.cost + self.problem.cost.wait(self.regions)[region] * way
        waits = before.waits + np.ceil(way / step_m - ROUNDING)
        waited = _Labels(before.node, row, there, cost, before.used + self._travel(way), waits)
        return self._kept(waited, step)

    def move(self, labels: _Labels, step: int) -> _Labels:
        """Continue labels along all arcs, at some travels each."""
        core, cost, regions = self.core, self.problem.cost, self.regions
        first = self.pointer[labels.node]
        counts = self.pointer[labels.node + 1] - first
        row = np.repeat(np.arange(len(labels.node)), counts)
        arc = self.order[np.arange(len(row)) + np.repeat(first - np.cumsum(counts) + counts, counts)]
        row, arc = np.repeat(row, len(_TRAVELS)), np.repeat(arc, len(_TRAVELS))
        x, head = labels.x_m[row], core.head[arc]
        low, high = core.window_m[head].T
        there = np.clip(x + np.resize(_TRAVELS * core.x_step_m, len(row)), low, high)
        near = np.abs(there - x) <= core.x_step_m * (1.0 + ROUNDING)
        row, arc, x, head, there = row[near], arc[near], x[near], head[near], there[near]
        source, target = core.region[core.tail[arc]], core.region[head]
        paid = labels.cost[row] + cost.at(regions, source, target, there - x)
        used = labels.used[:, row] + core.used[:, arc] + self._travel(np.abs(there - x))
        return self._kept(_Labels(head, row, there, paid, used, labels.waits[row]), step + 1)

    def _travel(self, way_m: FloatArray) -> FloatArray:
        counted = np.array([float(budget.travels) for budget in self.core.budgets]).reshape(-1, 1)
        return counted * way_m

    def _kept(self, labels: _Labels, step: int) -> _Labels:
        """Keep the most promising labels that the budgets allow, one per node and part of a largest move."""
        core, bounds = self.core, self.bounds
        region = core.region[labels.node]
        limits = np.array([budget.limit for budget in core.budgets]).reshape(-1, 1)
        still = self._travel(np.abs(self.regions.x_window_m[self.regions.goal, 0] - labels.x_m))
        open_ = (labels.used + still <= limits + ROUNDING).all(axis=0)
        at_goal = region == self.regions.goal
        open_ &= labels.waits + step + ~at_goal <= core.step_budget - 1
        prices = np.array(bounds.prices.prices) @ labels.used if len(core.budgets) else 0.0
        position = labels.x_m + self.problem.cost.offset_m(self.regions)[region]
        rank = labels.cost + prices - bounds.prices.travel * position + bounds.backward[region]
        rows = np.flatnonzero(open_)
        rows = rows[np.argsort(rank[rows], kind="stable")]
        cell = np.round(labels.x_m[rows] / (0.25 * core.x_step_m)).astype(np.int64)
        cell -= cell.min(initial=0)
        _, first = np.unique(labels.node[rows] * (1 + cell.max(initial=0)) + cell, return_index=True)
        return labels.take(rows[np.sort(first)[:_WIDTH]])


def _read(core: Core, steps: list[tuple[_Labels, _Labels]]) -> tuple[IntArray, FloatArray]:
    """Follow the cheapest label at the goal back, with the waits on the way."""
    label = int(np.argmin(steps[-1][0].cost))
    rows: list[int] = []
    x: list[float] = []
    here = float(steps[-1][0].x_m[label])
    for number in range(len(steps) - 1, -1, -1):
        arriving = steps[number][0]
        region = int(core.region[arriving.node[label]])
        came = float(arriving.x_m[label])
        waits = int(np.ceil(abs(here - came) / core.x_step_m - ROUNDING))
        rows += [region] * (1 + waits)
        x += np.linspace(here, came, 1 + waits).tolist() if waits else [came]
        if number:
            leaving = steps[number - 1][1]
            before = int(arriving.parent[label])
            here, label = float(leaving.x_m[before]), int(leaving.parent[before])
    return np.array(rows[::-1]), np.array(x[::-1])
