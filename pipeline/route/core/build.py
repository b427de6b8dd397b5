"""The core: all routes of cost at most a threshold T, expanded step by step.

A node is a region at a step i, an arc an admitted move (or a wait) from step i to i + 1. Where travel along X costs,
waits are no arcs: a route may stay in a region and travel for as long as the step budget allows, and steps count its
moves alone; so that what is gained by waiting elsewhere needs no other nodes. Two sweeps, from the start
and from the goal, propagate the least cost within the step budget, the x that can be reached, and the least use of
every budget; what cannot belong to a route of cost at most T within the budgets is left out. Hence a mixed-integer
program over the core is exact whenever its optimum is at most T.
"""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.route.bounds.budgets import Budget
from pipeline.route.bounds.shortest_paths import Bounds
from pipeline.route.cost.interface import MoveCost
from pipeline.route.metric import ROUNDING
from pipeline.route.moves.candidates import Moves
from pipeline.route.problem import RouteProblem
from pipeline.route.regions.table import RegionTable

_NODE_BYTES = 80
"""A region at a step: cost and two ends of x, swept from both ends, and what is kept of the sweeps."""


@dataclass(frozen=True, eq=False)
class Core:
    """Nodes and arcs of all routes of cost at most `threshold`.

    Attributes
    ----------
    step, region : (n,)
        Step (from 0) and row of the region table of each node.
    window_m : (n, 2)
        The x that can be reached there from the start and from which the goal can be reached.
    tail, head : (m,)
        Nodes an arc leaves and reaches.
    cost : (m,)
        What an arc costs at least, whatever its dx, less the price of its travel along X in the bounds.
    used : (budgets, m)
        What an arc uses of each budget, its x left out.
    threshold : float
        T.
    bound : float
        No route of cost at most T costs less, whatever its x; infinite when there is none.
    reach_m : (N - 1,)
        How far x can travel from each step to the next, with the waits before it.
    x_step_m, budgets : float, tuple
        The largest move along X, and the budgets it was built for.
    """

    step: IntArray
    region: IntArray
    window_m: FloatArray
    tail: IntArray
    head: IntArray
    cost: FloatArray
    used: FloatArray
    threshold: float
    bound: float
    reach_m: FloatArray
    x_step_m: float
    budgets: tuple[Budget, ...]

    @property
    def step_budget(self) -> int:
        """N."""
        return len(self.reach_m) + 1

    @property
    def empty(self) -> bool:
        """True when no route costs at most T."""
        return len(self.tail) == 0

    @property
    def reversed(self) -> "Core":
        """The same routes from the goal to the start; nodes in reverse order, arcs in the same."""
        last = len(self.step) - 1
        return replace(
            self,
            step=self.step_budget - 1 - self.step[::-1],
            region=self.region[::-1],
            window_m=self.window_m[::-1],
            tail=last - self.head,
            head=last - self.tail,
            reach_m=self.reach_m[::-1],
        )

    def restricted(self, arcs: BoolArray) -> "Core":
        """Keep only these arcs (m,), with their nodes, start and goal."""
        kept = np.zeros(len(self.step), dtype=bool)
        kept[self.tail[arcs]] = kept[self.head[arcs]] = kept[0] = kept[-1] = True
        number = np.cumsum(kept) - 1
        return replace(
            self,
            step=self.step[kept],
            region=self.region[kept],
            window_m=self.window_m[kept],
            tail=number[self.tail[arcs]],
            head=number[self.head[arcs]],
            cost=self.cost[arcs],
            used=self.used[:, arcs],
        )

    @property
    def regions(self) -> int:
        """Number of different regions."""
        return len(np.unique(self.region))

    @property
    def moves(self) -> Moves:
        """The moves among its arcs, each once, between rows of the region table."""
        source, target = self.region[self.tail], self.region[self.head]
        pairs = np.unique(np.column_stack([source, target])[source != target], axis=0)
        return Moves(pairs[:, 0], pairs[:, 1])


def build_core(problem: RouteProblem, regions: RegionTable, moves: Moves, bounds: Bounds, threshold: float) -> Core:
    """Expand all routes of cost at most `threshold` with at most the problem's step budget, within its budgets.

    `regions` and `moves` are those of the problem, or of its graph of states.
    """
    step_budget, x_step_m = problem.options.step_budget, problem.options.x_step_m
    limit = _limit(bounds, threshold)
    arcs = _Arcs.within(regions, moves, problem.cost, bounds, limit)
    left = np.array([budget.left(regions) + ROUNDING for budget in bounds.prices.budgets]).reshape(-1, 1)
    # A move, and where travel is no arc as many waits before it as are left when the moves so far are made.
    waits = np.arange(step_budget - 2, -1, -1.0) if problem.cost.counts_x else np.zeros(step_budget - 1)
    reach_m = np.asarray(x_step_m * (1.0 + waits))
    everywhere = _Windows.of_regions(arcs.window_m, step_budget)
    to_go = np.broadcast_to(bounds.backward[arcs.region], everywhere.low.shape)
    forward = _sweep(arcs, arcs.tail, arcs.head, arcs.start, everywhere, to_go, limit, reach_m)
    # The sweep from the goal only uses the x that the one from the start can reach: its bounds are sharper.
    back = forward.window.reversed()
    backward = _sweep(arcs, arcs.head, arcs.tail, arcs.goal, back, forward.cost[::-1], limit, reach_m[::-1]).reversed()
    low, high = backward.window.low, backward.window.high
    # The cost of the node itself is left out of the sweep from the start and counted in the one from the goal.
    alive = (forward.cost + backward.cost <= limit) & (low <= high + ROUNDING)
    alive &= (forward.used + backward.used <= left[:, None]).all(axis=0)
    # Hulls are relaxations: a node may look alive though no route leads through it.
    alive &= alive[0, arcs.start] and alive[-1, arcs.goal]
    number = np.cumsum(alive.ravel()).reshape(alive.shape) - 1
    tails, heads, chosen = [], [], []
    for i in range(step_budget - 1):
        use = np.flatnonzero(alive[i, arcs.tail])
        use = use[alive[i + 1, arcs.head[use]]]
        j, k = arcs.tail[use], arcs.head[use]
        reach = (low[i, j] - reach_m[i] <= high[i + 1, k] + ROUNDING) & (
            low[i + 1, k] <= high[i, j] + reach_m[i] + ROUNDING
        )
        cheap = forward.cost[i, j] + arcs.priced[use] + backward.cost[i + 1, k] <= limit
        spare = (forward.used[:, i, j] + arcs.used[:, use] + backward.used[:, i + 1, k] <= left).all(axis=0)
        kept = reach & cheap & spare
        tails.append(number[i, j[kept]])
        heads.append(number[i + 1, k[kept]])
        chosen.append(use[kept])
    step, local = np.nonzero(alive)
    use = np.concatenate(chosen)
    return Core(
        step=step,
        region=arcs.region[local],
        window_m=np.column_stack([low[alive], high[alive]]),
        tail=np.concatenate(tails),
        head=np.concatenate(heads),
        cost=arcs.cost[use],
        used=arcs.used[:, use],
        threshold=threshold,
        bound=float(backward.cost[0, arcs.start]) - bounds.credit,
        reach_m=reach_m,
        x_step_m=x_step_m,
        budgets=bounds.prices.budgets,
    )


def core_bytes(bounds: Bounds, threshold: float, step_budget: int) -> float:
    """Count the memory that the sweeps of a core take up: costs, x and use of budgets, per step and region."""
    inside = int(np.count_nonzero(bounds.forward + bounds.backward <= _limit(bounds, threshold)))
    return float(step_budget * inside * (_NODE_BYTES + 16 * len(bounds.prices.budgets)))


def _limit(bounds: Bounds, threshold: float) -> float:
    return threshold * (1.0 + ROUNDING) + bounds.credit


@dataclass(frozen=True, eq=False)
class _Arcs:
    """The moves among the regions with F + B <= T, and a wait in each of them; `priced` is the cost in F and B."""

    region: IntArray
    window_m: FloatArray
    tail: IntArray
    head: IntArray
    cost: FloatArray
    priced: FloatArray
    used: FloatArray
    start: int
    goal: int

    @classmethod
    def within(cls, regions: RegionTable, moves: Moves, cost: MoveCost, bounds: Bounds, limit: float) -> "_Arcs":
        inside = bounds.forward + bounds.backward <= limit
        # Start and goal stay, so that an empty core needs no special case.
        inside[[regions.start, regions.goal]] = True
        region = np.flatnonzero(inside)
        local = np.cumsum(inside) - 1
        use = inside[moves.source] & inside[moves.target]
        waits = local[[regions.goal]] if cost.counts_x else np.arange(len(region))
        tail = np.concatenate([local[moves.source[use]], waits])
        head = np.concatenate([local[moves.target[use]], waits])
        ends = (regions, region[tail], region[head])
        used = [budget.used(*ends) for budget in bounds.prices.budgets]
        least = cost.least(*ends, bounds.prices.travel)
        return cls(
            region=region,
            window_m=regions.x_window_m[region],
            tail=tail,
            head=head,
            cost=least,
            priced=least + bounds.prices.penalty(*ends),
            used=np.array(used).reshape(-1, len(tail)),
            start=int(local[regions.start]),
            goal=int(local[regions.goal]),
        )


@dataclass(frozen=True, eq=False)
class _Windows:
    """Least and largest x per step and region, shape (N, regions)."""

    low: FloatArray
    high: FloatArray

    @classmethod
    def of_regions(cls, window_m: FloatArray, steps: int) -> "_Windows":
        shape = (steps, len(window_m))
        return cls(np.broadcast_to(window_m[:, 0], shape), np.broadcast_to(window_m[:, 1], shape))

    def reversed(self) -> "_Windows":
        return _Windows(self.low[::-1], self.high[::-1])


@dataclass(frozen=True, eq=False)
class _Reach:
    """Least cost (N, regions), infinite out of reach; hull of the x that can be reached; least use of each budget."""

    cost: FloatArray
    window: _Windows
    used: FloatArray

    def reversed(self) -> "_Reach":
        return _Reach(self.cost[::-1], self.window.reversed(), self.used[:, ::-1])


def _sweep(
    arcs: _Arcs,
    source: IntArray,
    target: IntArray,
    root: int,
    allowed: _Windows,
    to_go: FloatArray,
    limit: float,
    reach_m: FloatArray,
) -> _Reach:
    """Propagate costs, x and use of budgets from one end through all steps, along the arcs from `source` to `target`.

    `reach_m` (N - 1,) is how far a step can travel along X. Nodes whose cost and least cost `to_go` (N, regions) exceed
    the limit are dropped.
    """
    shape = allowed.low.shape
    cost, low, high = np.full(shape, np.inf), np.full(shape, np.inf), np.full(shape, -np.inf)
    used = np.full((len(arcs.used), *shape), np.inf)
    cost[0, root], low[0, root], high[0, root] = 0.0, allowed.low[0, root], allowed.high[0, root]
    used[:, 0, root] = 0.0
    order = np.argsort(target, kind="stable")
    source, target = source[order], target[order]
    for i in range(1, len(cost)):
        along = np.flatnonzero((cost[i - 1] + to_go[i - 1] <= limit)[source])
        from_low = np.maximum(low[i - 1, source[along]] - reach_m[i - 1], allowed.low[i, target[along]])
        from_high = np.minimum(high[i - 1, source[along]] + reach_m[i - 1], allowed.high[i, target[along]])
        open_ = from_low <= from_high + ROUNDING
        along, from_low, from_high = along[open_], from_low[open_], from_high[open_]
        if len(along) == 0:
            break
        here, there, arc = source[along], target[along], order[along]
        first = np.flatnonzero(np.diff(there, prepend=-1))
        reached = there[first]
        cost[i, reached] = np.minimum.reduceat(cost[i - 1, here] + arcs.priced[arc], first)
        low[i, reached] = np.minimum.reduceat(from_low, first)
        high[i, reached] = np.maximum.reduceat(from_high, first)
        if len(used):
            used[:, i, reached] = np.minimum.reduceat(used[:, i - 1, here] + arcs.used[:, arc], first, axis=1)
    return _Reach(cost, _Windows(low, high), used)
