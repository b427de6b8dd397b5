"""Arcs of a core that no route within its threshold and budgets can pass, found by labels from both ends.

A way to the tail of an arc, the arc, and a way from its head to the goal are a route where their x can meet. Where no
such pair of labels costs at most the threshold and keeps all budgets, no route passes the arc. The cheapest pair is a
lower bound, and often the regions of the optimum.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.core.build import Core
from pipeline.route.core.labels import Labels, LabelSearch
from pipeline.route.metric import ROUNDING

_MOST_LABELS = 60_000
"""Labels from one end after which cores are left as they are."""
_MOST_PAIRS = 2_000_000
"""Pairs of labels compared at a time."""


@dataclass(frozen=True, eq=False)
class Pruned:
    """What is left of a core.

    Attributes
    ----------
    core : Core
        Without the arcs that no route can pass; empty where there is none.
    least : float
        No route costs less, its travel along X priced as in the core; infinite where there is none.
    region, x_m : (n,)
        Every region and x of the cheapest way found, moves longer than a largest one along X included; empty without.
    """

    core: Core
    least: float
    region: IntArray
    x_m: FloatArray


def prune(core: Core, prices: FloatArray, cost: float) -> Pruned | None:
    """Leave out the arcs of a core that is not empty that no route of at most this cost within the budgets passes.

    Costs are those of its arcs; `prices` (budgets,) make the search faster. None: there are too many labels.
    """
    forward, backward = LabelSearch.of(core, prices, cost), LabelSearch.of(core.reversed, prices, cost)
    ways, ways_back = _layers(forward), _layers(backward)
    if ways is None or ways_back is None:
        return None
    join = _Join.of(forward, ways_back)
    passed, least, best = np.zeros(len(core.tail), dtype=bool), np.inf, (0, 0, 0)
    for step, labels in enumerate(ways):
        ahead, arc, _ = forward.continued(labels)
        for first, second in join.pairs(ahead):
            passed[arc[first]] = True
            total = ahead.cost[first] + join.labels.cost[second]
            if len(total) and total.min() < least:
                cheapest = int(total.argmin())
                least, best = float(total[cheapest]), (step, int(ahead.parent[first[cheapest]]), int(second[cheapest]))
    if not np.isfinite(least):
        return Pruned(core.restricted(passed), least, np.empty(0, dtype=np.int64), np.empty(0))
    # Waiting at the goal is free, and the rest of the route.
    passed |= core.region[core.tail] == core.region[-1]
    return Pruned(core.restricted(passed), least, *join.way(core, ways, ways_back, best))


def _layers(search: LabelSearch) -> list[Labels] | None:
    """Find the labels of every step; None: there are too many."""
    layers, count = [search.root()], 1
    for _ in range(search.core.step_budget - 1):
        ahead, _, lower = search.continued(layers[-1])
        ahead = ahead.take(np.lexsort((lower, ahead.node)))
        # Costs depend on x, which labels leave open: a way that takes more steps may be better after all.
        kept, _ = search.undominated(ahead, {}, None)
        count += len(kept)
        if count > _MOST_LABELS:
            return None
        if len(kept) == 0:
            break
        layers.append(kept)
    return layers


@dataclass(frozen=True, eq=False)
class _Join:
    """Labels from the goal: sorted by their nodes in the core, where those of each node begin, their number before."""

    labels: Labels
    pointer: IntArray
    number: IntArray
    travels: FloatArray
    limits: FloatArray
    cost: float

    @classmethod
    def of(cls, search: LabelSearch, ways_back: list[Labels]) -> "_Join":
        labels = ways_back[0]
        for layer in ways_back[1:]:
            labels = labels.joined(layer)
        node = len(search.core.step) - 1 - labels.node
        order = np.argsort(node, kind="stable")
        pointer = np.searchsorted(node[order], np.arange(len(search.core.step) + 1))
        return cls(labels.take(order), pointer, order, search.travels, search.limits, search.cost)

    def pairs(self, ahead: Labels) -> Iterator[tuple[IntArray, IntArray]]:
        """Give the pairs of labels that meet within cost and budgets, a block at a time: rows of both."""
        first = self.pointer[ahead.node]
        counts = self.pointer[ahead.node + 1] - first
        begins = np.flatnonzero(np.diff(np.cumsum(counts) // _MOST_PAIRS, prepend=-1))
        for rows in np.split(np.arange(len(counts)), begins[1:]):
            here = np.repeat(rows, counts[rows])
            there = np.arange(len(here)) + np.repeat(first[rows] - np.cumsum(counts[rows]) + counts[rows], counts[rows])
            fit = self._fit(ahead, here, there)
            yield here[fit], there[fit]

    def _fit(self, ahead: Labels, here: IntArray, there: IntArray) -> IntArray:
        back = self.labels
        fit = ahead.cost[here] + back.cost[there] <= self.cost * (1.0 + ROUNDING)
        apart = np.maximum(ahead.best[0, here] - back.best[1, there], back.best[0, there] - ahead.best[1, here])
        used = ahead.used[:, here] + back.used[:, there] + np.outer(self.travels, np.maximum(apart, 0.0))
        fit &= (used <= self.limits[:, None] + ROUNDING).all(axis=0)
        fit &= ahead.reach[0, here] <= back.reach[1, there] + ROUNDING
        fit &= back.reach[0, there] <= ahead.reach[1, here] + ROUNDING
        return np.flatnonzero(fit)

    def way(
        self, core: Core, ways: list[Labels], ways_back: list[Labels], best: tuple[int, int, int]
    ) -> tuple[IntArray, FloatArray]:
        """Give regions and x of a pair of labels: step and label at the tail of the arc, and label at its head."""
        step, label, pair = best
        begins = np.cumsum([0, *(len(layer) for layer in ways_back)])
        place = int(self.number[pair])
        layer = int(np.searchsorted(begins, place, side="right")) - 1
        # Where x may be on arriving, as near as possible to where it may be before.
        near = np.clip(self.labels.best[0, pair], *ways[step].reach[:, label])
        meeting = float(np.clip(near, *self.labels.reach[:, pair]))
        before, x = _chain(ways[: step + 1], label, meeting)
        after, x_after = _chain(ways_back[: layer + 1], place - int(begins[layer]), meeting)
        region = core.region[[*before[::-1], *(len(core.step) - 1 - node for node in after)]]
        count = int(np.argmax(region == region[-1])) + 1
        return region[:count], np.array([*x[::-1], *x_after])[:count]


def _chain(layers: list[Labels], label: int, x_m: float) -> tuple[list[int], list[float]]:
    """Follow a label of the last layer back to the root: nodes, and x, which stays as long as it can."""
    nodes, x = [], []
    for labels in layers[::-1]:
        x_m = float(np.clip(x_m, *labels.reach[:, label]))
        nodes.append(int(labels.node[label]))
        x.append(x_m)
        label = int(labels.parent[label])
    return nodes, x
