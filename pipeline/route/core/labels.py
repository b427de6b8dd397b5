"""Labels: ways from one end of a core to its nodes.

A label is a way from the start to a node of the core: its cost, what it has used of every budget, and where its x
may be. With [l, h] for the x that it can have reached, the least travel along X that ends at x is

    f(x) = v + dist(x, [a, b]),  l <= x <= h,

since staying is free and every metre costs one: a move to a region with the window [p, q] widens [l, h] by how far x
can travel and cuts it to [p, q]; [a, b] is cut to it as well, or moved to its nearest end, and v grows by as much.
v is part of what is used of a budget that counts travel along X.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.route.core.build import Core
from pipeline.route.metric import ROUNDING

_BLOCK = 512
"""Labels of a region compared at a time."""


@dataclass(frozen=True, eq=False)
class Labels:
    """Labels (n,) of one step.

    Attributes
    ----------
    node, parent : (n,)
        Node of the core, and label of the step before.
    cost : (n,)
    used : (budgets, n)
    best : (2, n)
        a and b: where x has travelled least.
    reach : (2, n)
        l and h: the x that can have been reached.
    """

    node: IntArray
    parent: IntArray
    cost: FloatArray
    used: FloatArray
    best: FloatArray
    reach: FloatArray

    def __len__(self) -> int:
        return len(self.node)

    def take(self, rows: IntArray) -> "Labels":
        """Keep only these, in their order."""
        return Labels(
            self.node[rows],
            self.parent[rows],
            self.cost[rows],
            self.used[:, rows],
            self.best[:, rows],
            self.reach[:, rows],
        )

    def joined(self, others: "Labels") -> "Labels":
        """Append others."""
        pairs = ((getattr(self, name), getattr(others, name)) for name in self.__dataclass_fields__)
        return Labels(*(np.concatenate(pair, axis=-1) for pair in pairs))


@dataclass(frozen=True, eq=False)
class LabelSearch:
    """A core, and what any way from each of its nodes to the goal costs and uses at least, x left out.

    Labels that cost more than `cost`, at the prices of the budgets (budgets,) or without them, are dropped.
    """

    core: Core
    prices: FloatArray
    limits: FloatArray
    travels: FloatArray
    cost: float
    cost_to_go: FloatArray
    priced_to_go: FloatArray
    use_to_go: FloatArray
    order: IntArray
    pointer: IntArray

    @classmethod
    def of(cls, core: Core, prices: FloatArray, cost: float) -> "LabelSearch":
        """Compute what ways to the goal cost and use at least."""
        order = np.argsort(core.tail, kind="stable")
        return cls(
            core=core,
            prices=prices,
            limits=np.array([budget.limit for budget in core.budgets]),
            travels=np.array([float(budget.travels) for budget in core.budgets]),
            cost=cost,
            cost_to_go=_to_go(core, core.cost),
            priced_to_go=_to_go(core, core.cost + prices @ core.used),
            use_to_go=np.array([_to_go(core, used) for used in core.used]).reshape(-1, len(core.step)),
            order=order,
            pointer=np.searchsorted(core.tail[order], np.arange(len(core.step) + 1)),
        )

    def root(self) -> Labels:
        """Make the label of the start."""
        nothing, x = np.zeros(1, dtype=np.int64), np.full((2, 1), self.core.window_m[0, 0])
        return Labels(nothing, nothing, np.zeros(1), np.zeros((len(self.limits), 1)), x, x)

    def continued(self, labels: Labels) -> tuple[Labels, IntArray, FloatArray]:
        """Continue labels along all arcs they can take within the cost and the budgets.

        Returns the labels at the heads of the arcs, the arcs, and lower bounds on the cost of routes through them.
        """
        core = self.core
        first, counts = self.pointer[labels.node], self.pointer[labels.node + 1] - self.pointer[labels.node]
        parent = np.repeat(np.arange(len(labels)), counts)
        arc = self.order[np.repeat(first - np.cumsum(counts) + counts, counts) + np.arange(len(parent))]
        node = core.head[arc]
        window = core.window_m[node].T
        reach = core.reach_m[core.step[core.tail[arc]]]
        low = np.maximum(labels.reach[0, parent] - reach, window[0])
        high = np.minimum(labels.reach[1, parent] + reach, window[1])
        before = labels.best[:, parent]
        travelled = np.maximum(before[0] - high, 0.0) + np.maximum(low - before[1], 0.0)
        ahead = Labels(
            node=node,
            parent=parent,
            cost=labels.cost[parent] + core.cost[arc],
            used=labels.used[:, parent] + core.used[:, arc] + np.outer(self.travels, travelled),
            best=np.clip(before, low, high),
            reach=np.stack([low, high]),
        )
        lower, possible = self._bounds(ahead)
        keep = np.flatnonzero((low <= high + ROUNDING) & possible & (lower <= self.cost * (1.0 + ROUNDING)))
        return ahead.take(keep), arc[keep], lower[keep]

    def extend(self, labels: Labels, known_cost: float) -> tuple[Labels, tuple[float, int] | None]:
        """Continue labels: those not at the goal, sorted by region and bound; cost and parent of the best at the goal.

        Routes of `known_cost` are known: only less costly ones count.
        """
        ahead, _, lower = self.continued(labels)
        region = self.core.region[ahead.node]
        arrived = np.flatnonzero((lower < known_cost) & (region == self.core.region[-1]))
        rows = np.flatnonzero((lower < known_cost) & (region != self.core.region[-1]))
        left = ahead.take(rows[np.lexsort((lower[rows], region[rows]))])
        if len(arrived) == 0:
            return left, None
        best = arrived[np.argmin(ahead.cost[arrived])]
        return left, (float(ahead.cost[best]), int(ahead.parent[best]))

    def _bounds(self, labels: Labels) -> tuple[FloatArray, BoolArray]:
        """Bound the cost of routes through labels (n,) from below, and tell which can keep all budgets."""
        goal_x = self.core.window_m[-1, 0]
        to_goal = np.maximum(labels.best[0] - goal_x, 0.0) + np.maximum(goal_x - labels.best[1], 0.0)
        used = labels.used + np.outer(self.travels, to_goal)
        possible = (used + self.use_to_go[:, labels.node] <= self.limits[:, None] + ROUNDING).all(axis=0)
        priced = labels.cost + self.priced_to_go[labels.node] + self.prices @ (used - self.limits[:, None])
        return np.maximum(labels.cost + self.cost_to_go[labels.node], priced), np.asarray(possible)

    def undominated(self, labels: Labels, known: dict[int, Labels], width: int | None) -> tuple[Labels, bool]:
        """Leave out dominated labels, sorted by region, and add the others to those known; also whether `width` cut."""
        region = self.core.region[labels.node]
        begins = np.flatnonzero(np.diff(region, prepend=-1))
        parts, cut = [np.empty(0, dtype=np.int64)], False
        for begin, end in pairwise([*begins.tolist(), len(region)]):
            number, room = int(region[begin]), width
            for first in range(begin, end, _BLOCK):
                rows = self._undominated(labels, np.arange(first, min(first + _BLOCK, end)), known.get(number))
                cut |= room is not None and len(rows) > room
                rows = rows[:room]
                room = None if room is None else room - len(rows)
                kept = labels.take(rows)
                known[number] = known[number].joined(kept) if number in known else kept
                parts.append(rows)
        return labels.take(np.concatenate(parts)), cut

    def _undominated(self, labels: Labels, rows: IntArray, known: Labels | None) -> IntArray:
        """Keep those rows of labels, all in one region, that neither known ones nor each other make superfluous."""
        if known is not None:
            rows = rows[~self._dominates(known, labels.take(rows)).any(axis=0)]
        here = labels.take(rows)
        by = self._dominates(here, here)
        # Of labels that dominate each other the first is kept.
        by &= ~by.T | np.tri(len(rows), k=-1, dtype=bool).T
        return np.asarray(rows[~by.any(axis=0)])

    def _dominates(self, labels: Labels, others: Labels) -> BoolArray:
        """Tell which labels (n,) make others (m,) superfluous. Shape (n, m)."""

        def pair(values: FloatArray, theirs: FloatArray) -> tuple[FloatArray, FloatArray]:
            return values[:, None], theirs[None, :]

        cost, its_cost = pair(labels.cost, others.cost)
        low, its_low = pair(labels.reach[0], others.reach[0])
        high, its_high = pair(labels.reach[1], others.reach[1])
        found = (cost <= its_cost) & (low <= its_low) & (high >= its_high)
        # How much farther x has to travel from its best place than from theirs, at most.
        (a, its_a), (b, its_b) = pair(labels.best[0], others.best[0]), pair(labels.best[1], others.best[1])
        farther = np.maximum(np.maximum(a - its_a, its_b - b), 0.0)
        for travels, used, its_used in zip(self.travels, labels.used, others.used, strict=True):
            found &= used[:, None] + travels * farther <= its_used
        return np.asarray(found, dtype=bool)


def _to_go(core: Core, values: FloatArray) -> FloatArray:
    """Compute the least sum of what arcs (m,) cost or use from each node to the goal. Shape (n,)."""
    least = np.full(len(core.step), np.inf)
    least[-1] = 0.0
    step = core.step[core.tail]
    order = np.argsort(step, kind="stable")
    pointer = np.searchsorted(step[order], np.arange(core.step_budget + 1))
    for i in range(core.step_budget - 2, -1, -1):
        arcs = order[pointer[i] : pointer[i + 1]]
        np.minimum.at(least, core.tail[arcs], values[arcs] + least[core.head[arcs]])
    return least
