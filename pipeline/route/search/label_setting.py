"""Label setting over a core: the route of least cost within budgets, exactly.

A label is a way from the start to a node of the core: its cost, what it has used of every budget, and where its x
may be. With [l, h] for the x that it can have reached, the least travel along X that ends at x is

    f(x) = v + dist(x, [a, b]),  l <= x <= h,

since staying is free and every metre costs one: a move to a region with the window [p, q] widens [l, h] by the largest
move per step and cuts it to [p, q]; [a, b] is cut to it as well, or moved to its nearest end, and v grows by as much.
v is part of what is used of a budget that counts travel along X.

A label is dropped when it cannot reach the goal within the budgets and the cost allowed, or when another one in the
same region, after as many steps or fewer, costs and uses no more wherever its x goes. What is left at the goal is the
optimum. Budgets that are almost used up leave few labels, where the relaxation of a mixed-integer program says little
(Desrosiers et al., *Time constrained routing and scheduling*, 1995).
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.route.deadline import Deadline
from pipeline.route.metric import ROUNDING
from pipeline.route.programs.core import Core
from pipeline.route.programs.solution import StepSequence
from pipeline.solvers.highs import Outcome
from pipeline.status import Status

SOLVER = "label setting"
WIDTH = 10
"""Labels kept per region and step by a search that looks for some good route first."""
_MOST_LABELS = 200_000
"""Labels after which a search gives up: comparing them with each other takes the square of their number."""
_BLOCK = 512
"""Labels of a region compared at a time."""


@dataclass(frozen=True, eq=False)
class _Labels:
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

    def take(self, rows: IntArray) -> "_Labels":
        """Keep only these, in their order."""
        return _Labels(
            self.node[rows],
            self.parent[rows],
            self.cost[rows],
            self.used[:, rows],
            self.best[:, rows],
            self.reach[:, rows],
        )

    def joined(self, others: "_Labels") -> "_Labels":
        """Append others."""
        pairs = ((getattr(self, name), getattr(others, name)) for name in self.__dataclass_fields__)
        return _Labels(*(np.concatenate(pair, axis=-1) for pair in pairs))


def solve_labels(
    core: Core, prices: FloatArray, deadline: Deadline, cost: float = np.inf, width: int | None = None
) -> StepSequence:
    """Find the route of least cost over a core that is not empty.

    Parameters
    ----------
    prices : (budgets,)
        Lagrange multipliers of the budgets: good ones drop more labels.
    cost : float
        Routes that cost more are not looked for.
    width : int, optional
        Labels kept per region and step. With it the search is fast, and proves nothing.

    Returns
    -------
    StepSequence
        Its status is OPTIMAL or INFEASIBLE with a proof, for routes of at most `cost`; TIME_LIMIT or, when there are
        too many labels or `width` left some out, NOT_CONVERGED without.
    """
    search = _Search.of(core, prices, cost)
    layers = [search.root()]
    known: dict[int, _Labels] = {}
    best, last, complete, count = np.inf, (0, 0), True, 0
    for step in range(core.step_budget - 1):
        if count > _MOST_LABELS or (width is None and deadline.passed):
            status = Status.TIME_LIMIT if deadline.passed else Status.NOT_CONVERGED
            return search.sequence(layers, last, best, status)
        ahead, at_goal = search.extend(layers[-1], best)
        if at_goal and at_goal[0] < best:
            best, last = at_goal[0], (step, at_goal[1])
        kept, cut = search.undominated(ahead, known, width)
        complete, count = complete and not cut, count + len(kept)
        if len(kept) == 0:
            break
        layers.append(kept)
    proven = Status.OPTIMAL if np.isfinite(best) else Status.INFEASIBLE
    return search.sequence(layers, last, best, proven if complete else Status.NOT_CONVERGED)


@dataclass(frozen=True, eq=False)
class _Search:
    """A core, and what any way from each of its nodes to the goal costs and uses at least, x left out."""

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
    def of(cls, core: Core, prices: FloatArray, cost: float) -> "_Search":
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

    def root(self) -> _Labels:
        """Make the label of the start."""
        nothing, x = np.zeros(1, dtype=np.int64), np.full((2, 1), self.core.window_m[0, 0])
        return _Labels(nothing, nothing, np.zeros(1), np.zeros((len(self.limits), 1)), x, x)

    def extend(self, labels: _Labels, known_cost: float) -> tuple[_Labels, tuple[float, int] | None]:
        """Extend labels by all arcs: those still worth it, the best first, and cost and parent of the best at the goal.

        Routes of `known_cost` are known: only less costly ones count.
        """
        core = self.core
        first, counts = self.pointer[labels.node], self.pointer[labels.node + 1] - self.pointer[labels.node]
        parent = np.repeat(np.arange(len(labels)), counts)
        arc = self.order[np.repeat(first - np.cumsum(counts) + counts, counts) + np.arange(len(parent))]
        node = core.head[arc]
        window = core.window_m[node].T
        low = np.maximum(labels.reach[0, parent] - core.x_step_m, window[0])
        high = np.minimum(labels.reach[1, parent] + core.x_step_m, window[1])
        before = labels.best[:, parent]
        travelled = np.maximum(before[0] - high, 0.0) + np.maximum(low - before[1], 0.0)
        ahead = _Labels(
            node=node,
            parent=parent,
            cost=labels.cost[parent] + core.cost[arc],
            used=labels.used[:, parent] + core.used[:, arc] + np.outer(self.travels, travelled),
            best=np.clip(before, low, high),
            reach=np.stack([low, high]),
        )
        lower, possible = self._bounds(ahead)
        keep = (low <= high + ROUNDING) & possible & (lower <= self.cost * (1.0 + ROUNDING)) & (lower < known_cost)
        there = core.region[node] == core.region[-1]
        arrived = np.flatnonzero(keep & there)
        rows = np.flatnonzero(keep & ~there)
        left = ahead.take(rows[np.lexsort((lower[rows], core.region[node[rows]]))])
        if len(arrived) == 0:
            return left, None
        best = arrived[np.argmin(ahead.cost[arrived])]
        return left, (float(ahead.cost[best]), int(parent[best]))

    def _bounds(self, labels: _Labels) -> tuple[FloatArray, BoolArray]:
        """Bound the cost of routes through labels (n,) from below, and tell which can keep all budgets."""
        goal_x = self.core.window_m[-1, 0]
        to_goal = np.maximum(labels.best[0] - goal_x, 0.0) + np.maximum(goal_x - labels.best[1], 0.0)
        used = labels.used + np.outer(self.travels, to_goal)
        possible = (used + self.use_to_go[:, labels.node] <= self.limits[:, None] + ROUNDING).all(axis=0)
        priced = labels.cost + self.priced_to_go[labels.node] + self.prices @ (used - self.limits[:, None])
        return np.maximum(labels.cost + self.cost_to_go[labels.node], priced), np.asarray(possible)

    def undominated(self, labels: _Labels, known: dict[int, _Labels], width: int | None) -> tuple[_Labels, bool]:
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

    def _undominated(self, labels: _Labels, rows: IntArray, known: _Labels | None) -> IntArray:
        """Keep those rows of labels, all in one region, that neither known ones nor each other make superfluous."""
        if known is not None:
            rows = rows[~self._dominates(known, labels.take(rows)).any(axis=0)]
        here = labels.take(rows)
        by = self._dominates(here, here)
        # Of labels that dominate each other the first is kept.
        by &= ~by.T | np.tri(len(rows), k=-1, dtype=bool).T
        return np.asarray(rows[~by.any(axis=0)])

    def _dominates(self, labels: _Labels, others: _Labels) -> BoolArray:
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

    def sequence(self, layers: list[_Labels], last: tuple[int, int], cost: float, status: Status) -> StepSequence:
        """Follow the parents of the last label before the goal, and choose x backwards: it stays as long as it can."""
        bound = cost if status is Status.OPTIMAL else min(max(float(self.cost_to_go[0]), self.core.bound), cost)
        columns = len(self.core.tail)
        if not np.isfinite(cost):
            none = Outcome(status, np.empty(0), np.inf, np.inf if status is Status.INFEASIBLE else bound, np.inf)
            return StepSequence(np.empty(0, dtype=np.int64), np.empty(0), none, columns, SOLVER)
        region, x = [int(self.core.region[-1])], [float(self.core.window_m[-1, 0])]
        label = last[1]
        for step in range(last[0], -1, -1):
            layer = layers[step]
            region.append(int(self.core.region[layer.node[label]]))
            x.append(float(np.clip(x[-1], layer.reach[0, label], layer.reach[1, label])))
            label = int(layer.parent[label])
        outcome = Outcome(status, np.array(x[::-1]), cost, bound, (cost - bound) / cost if cost > 0.0 else 0.0)
        return StepSequence(np.array(region[::-1]), np.array(x[::-1]), outcome, columns, SOLVER)


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
