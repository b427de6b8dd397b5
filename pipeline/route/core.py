"""The core: all routes cheaper than a threshold T, laid out step by step.

A node is a region at a step i, an arc an admitted move (or a wait) from step i to i + 1. Costs from the start
and to the goal within the step budget, and the x that can be reached from either end, are carried along both
ways; what cannot belong to a route of at most T is left out. Hence a mixed-integer program over the core is
exact whenever its optimum is at most T.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.machine.geometry import BoolArray, FloatArray, IntArray
from pipeline.route.moves import Moves
from pipeline.route.regions import RegionTable
from pipeline.route.relaxation import Bounds

_ROUNDING = 1e-9


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
        kappa of the region left, zero once the goal is reached: gamma kappa of (25)-(26).
    threshold : float
        T.
    bound : float
        No route of cost at most T costs less, whatever x does in it; infinite when there is none.
    """

    step: IntArray
    region: IntArray
    window_m: FloatArray
    tail: IntArray
    head: IntArray
    cost: FloatArray
    threshold: float
    bound: float

    @property
    def empty(self) -> bool:
        """True when no route costs at most T."""
        return len(self.tail) == 0

    @property
    def regions(self) -> int:
        """Number of different regions."""
        return len(np.unique(self.region))


def build_core(
    regions: RegionTable, moves: Moves, bounds: Bounds, threshold: float, step_budget: int, x_step_m: float
) -> Core:
    """Lay out all routes of cost at most `threshold` with at most `step_budget` positions."""
    limit = threshold * (1.0 + _ROUNDING)
    arcs = _Arcs.within(regions, moves, bounds, limit)
    everywhere = _Windows.of_regions(arcs.window_m, step_budget)
    forward = _sweep(arcs, arcs.tail, arcs.head, arcs.start, everywhere, x_step_m)
    # The way back only uses the x that the way out can reach: its costs become sharper bounds.
    backward = _sweep(arcs, arcs.head, arcs.tail, arcs.goal, forward.window.reversed(), x_step_m).reversed()
    low, high = backward.window.low, backward.window.high
    # Costs of a sweep leave out the node itself on the way out and count it on the way back.
    alive = (forward.cost + backward.cost <= limit) & (low <= high + _ROUNDING)
    # Hulls are relaxations: a node may look alive when no way through it leads from the start to the goal.
    alive &= alive[0, arcs.start] and alive[-1, arcs.goal]
    bound = float(backward.cost[0, arcs.start])
    number = np.cumsum(alive.ravel()).reshape(alive.shape) - 1
    tails, heads, costs = [], [], []
    for i in range(step_budget - 1):
        j, k = arcs.tail, arcs.head
        reach = (low[i, j] - x_step_m <= high[i + 1, k] + _ROUNDING) & (
            low[i + 1, k] <= high[i, j] + x_step_m + _ROUNDING
        )
        cheap = forward.cost[i, j] + arcs.cost + backward.cost[i + 1, k] <= limit
        use = np.flatnonzero(alive[i, j] & alive[i + 1, k] & reach & cheap)
        tails.append(number[i, j[use]])
        heads.append(number[i + 1, k[use]])
        costs.append(arcs.cost[use])
    step, local = np.nonzero(alive)
    return Core(
        step=step,
        region=arcs.region[local],
        window_m=np.column_stack([low[alive], high[alive]]),
        tail=np.concatenate(tails),
        head=np.concatenate(heads),
        cost=np.concatenate(costs),
        threshold=threshold,
        bound=bound,
    )


@dataclass(frozen=True, eq=False)
class _Arcs:
    """The moves among the regions with F + B <= T, and a wait in each of them."""

    region: IntArray
    window_m: FloatArray
    tail: IntArray
    head: IntArray
    cost: FloatArray
    start: int
    goal: int

    @classmethod
    def within(cls, regions: RegionTable, moves: Moves, bounds: Bounds, limit: float) -> "_Arcs":
        inside = bounds.forward + bounds.backward <= limit
        # Start and goal stay, so that an empty core needs no special case.
        inside[[regions.start, regions.goal]] = True
        region = np.flatnonzero(inside)
        local = np.cumsum(inside) - 1
        use = inside[moves.source] & inside[moves.target]
        waits = np.arange(len(region))
        tail = np.concatenate([local[moves.source[use]], waits])
        cost = regions.kappa[region]
        cost[local[regions.goal]] = 0.0
        return cls(
            region=region,
            window_m=regions.x_window_m[region],
            tail=tail,
            head=np.concatenate([local[moves.target[use]], waits]),
            cost=cost[tail],
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
    """Least cost (N, regions), infinite out of reach, and the hull of the x that can be reached."""

    cost: FloatArray
    window: _Windows

    def reversed(self) -> "_Reach":
        return _Reach(self.cost[::-1], self.window.reversed())


def _sweep(arcs: _Arcs, source: IntArray, target: IntArray, root: int, allowed: _Windows, x_step_m: float) -> _Reach:
    """Carry costs and x from one end through all steps, along the arcs from `source` to `target`."""
    shape = allowed.low.shape
    cost, low, high = np.full(shape, np.inf), np.full(shape, np.inf), np.full(shape, -np.inf)
    cost[0, root], low[0, root], high[0, root] = 0.0, allowed.low[0, root], allowed.high[0, root]
    order = np.argsort(target, kind="stable")
    source, target, weight = source[order], target[order], arcs.cost[order]
    reached, first = np.unique(target, return_index=True)
    for i in range(1, len(cost)):
        from_low = np.maximum(low[i - 1, source] - x_step_m, allowed.low[i, target])
        from_high = np.minimum(high[i - 1, source] + x_step_m, allowed.high[i, target])
        open_: BoolArray = from_low <= from_high + _ROUNDING
        cost[i, reached] = np.minimum.reduceat(np.where(open_, cost[i - 1, source] + weight, np.inf), first)
        low[i, reached] = np.minimum.reduceat(np.where(open_, from_low, np.inf), first)
        high[i, reached] = np.maximum.reduceat(np.where(open_, from_high, -np.inf), first)
    return _Reach(cost, _Windows(low, high))
