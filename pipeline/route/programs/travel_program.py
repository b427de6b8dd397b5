"""The mixed-integer program over a core for costs that depend on the travel along X.

As in `core_program` there is a boolean delta per arc. For each step there are P_x on arriving and on leaving, and the
whole number m of waits between them; for each arc its travel e and its cost t, for each node its travel by waits, y:

- (8)-(12): one unit leaves the start and reaches the goal,
- (18): both P_x are in the window of the region,
- (13): |e| <= Delta X delta; the sum of e over the arcs of a step is the change of P_x from leaving to arriving,
- |y| <= W delta and |y| <= m Delta X; y is the change of P_x from arriving to leaving,
- t >= constant delta + slope e for every tangent of the cost, which is convex: any tangents make a relaxation. All is
  zero where delta = 0: for each arc this is the convex hull of "used at its cost" and "not used" (its perspective),
- moves and waits together are at most N - 1; the arcs use no more than each budget.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csc_array

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.core.build import Core
from pipeline.route.cost.interface import MoveCost
from pipeline.route.programs.blocks import Blocks
from pipeline.route.regions.table import RegionTable
from pipeline.solvers.highs import LinearProgram


@dataclass(eq=False)
class Tangents:
    """The tangents found so far, by pair of regions: moves between the same regions at other steps share them.

    Attributes
    ----------
    regions, cost : RegionTable, MoveCost
        The table that pairs are rows of, and what is touched.
    price : float
        Of travel: every cost is touched where it is least at this price, so that the relaxation is no weaker than the
        bound by prices.
    """

    regions: RegionTable
    cost: MoveCost
    price: float
    _touched: set[tuple[int, int, float]] = field(default_factory=set)

    def add(self, source: IntArray, target: IntArray, dx_m: FloatArray) -> bool:
        """Touch the costs of moves (m,) at dx (m,); whether any tangent is new."""
        before = len(self._touched)
        self._touched.update(zip(source.tolist(), target.tolist(), dx_m.tolist(), strict=True))
        return len(self._touched) > before

    def of(self, source: IntArray, target: IntArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """List the tangents of arcs (m,): which arc, constant and slope of each. Shapes (k,)."""
        first = self.cost.first_travel(self.regions, source, target, self.price)
        arcs, travel = [np.tile(np.arange(len(source)), len(first))], [first.ravel()]
        if self._touched:
            pairs = source.astype(np.int64) * len(self.regions) + target
            order = np.argsort(pairs, kind="stable")
            touched = np.array(sorted(self._touched))
            keys = touched[:, 0].astype(np.int64) * len(self.regions) + touched[:, 1].astype(np.int64)
            begin, end = (np.searchsorted(pairs[order], keys, side=side) for side in ("left", "right"))
            for first_arc, last_arc, dx in zip(begin.tolist(), end.tolist(), touched[:, 2].tolist(), strict=True):
                arcs.append(order[first_arc:last_arc])
                travel.append(np.full(last_arc - first_arc, dx))
        arc = np.concatenate(arcs)
        constant, slope = self.cost.tangent(self.regions, source[arc], target[arc], np.concatenate(travel))
        return arc, constant, slope


@dataclass(frozen=True, eq=False)
class TravelProgram:
    """The program, with what it takes to read a solution."""

    program: LinearProgram
    core: Core
    leaving: slice
    arriving: slice
    travel: slice

    def read(self, values: FloatArray) -> tuple[IntArray, FloatArray]:
        """Read the region and the x of every step up to the goal from a solution, waits included. Shapes (n,)."""
        core = self.core
        used = np.flatnonzero(values[: len(core.tail)] > 0.5)
        used = used[np.argsort(core.step[core.tail[used]])]
        regions = core.region[np.concatenate([core.tail[used], core.head[used[-1:]]])]
        arriving, leaving = values[self.arriving], values[self.leaving]
        rows: list[int] = []
        x: list[float] = []
        for region, here, there in zip(regions.tolist(), arriving.tolist(), leaving.tolist(), strict=True):
            waits = int(np.ceil(abs(there - here) / core.x_step_m - 1e-6))
            rows += [region] * (1 + waits)
            x += np.linspace(here, there, 1 + waits).tolist() if waits else [here]
        return np.array(rows), np.array(x)


def build_travel_program(core: Core, tangents: Tangents) -> TravelProgram:
    """Write the program over a core that is not empty."""
    N, step_m, nodes, arcs = core.step_budget, core.x_step_m, len(core.step), len(core.tail)
    goal = core.region[-1]
    moving = core.region[core.tail] != goal
    node, arc = np.arange(nodes), np.arange(arcs)
    leaves, enters = _ones(core.tail, arc, (nodes, arcs)), _ones(core.head, arc, (nodes, arcs))
    at_node = _ones(core.step, node, (N, nodes))
    at_arc = _ones(core.step[core.tail], arc, (N - 1, arcs))
    # delta of the last step is what enters it; of all others what leaves.
    delta = leaves + csc_array(enters.multiply((core.step == N - 1)[:, None]))
    supply = np.zeros(nodes)
    supply[0], supply[-1] = 1.0, -1.0
    eye_arcs, eye_nodes, eye_steps = (
        _ones(arc, arc, (arcs, arcs)),
        _ones(node, node, (nodes, nodes)),
        csc_array(np.eye(N)),
    )
    own = tangents.regions.x_window_m[core.region]
    most_waits = np.where(core.region == goal, 0.0, np.maximum(N - 2 - core.step, 0)) * step_m
    of_arc, constant, slope = tangents.of(core.region[core.tail], core.region[core.head])
    rows = Blocks(
        {"delta": arcs, "arrive": N, "leave": N, "waits": N, "e": arcs, "t": arcs, "ahead": nodes, "back": nodes}
    )
    rows.add({"delta": leaves - enters}, supply, supply)
    for side, window in (("arrive", core.window_m), ("leave", own)):
        for end, least, most in ((window[:, 0], 0.0, np.inf), (window[:, 1], -np.inf, 0.0)):
            rows.add({"delta": -(at_node.multiply(end) @ delta), side: eye_steps}, least, most)
    rows.add({"arrive": eye_steps[1:], "leave": -eye_steps[:-1], "e": -at_arc}, 0.0, 0.0)
    rows.add({"arrive": -eye_steps, "leave": eye_steps, "ahead": -at_node, "back": at_node}, 0.0, 0.0)
    for sign in (1.0, -1.0):
        rows.add({"delta": -step_m * eye_arcs, "e": sign * eye_arcs}, -np.inf, 0.0)
    row, shape = np.arange(len(of_arc)), (len(of_arc), arcs)
    rows.add(
        {
            "delta": csc_array((-constant, (row, of_arc)), shape=shape),
            "e": csc_array((-slope, (row, of_arc)), shape=shape),
            "t": _ones(row, of_arc, shape),
        },
        0.0,
        np.inf,
    )
    rows.add(
        {"delta": -csc_array(delta.multiply(most_waits[:, None])), "ahead": eye_nodes, "back": eye_nodes}, -np.inf, 0.0
    )
    rows.add({"waits": step_m * eye_steps, "ahead": -at_node, "back": -at_node}, 0.0, np.inf)
    rows.add({"delta": csc_array(moving[None].astype(float)), "waits": csc_array(np.ones((1, N)))}, -np.inf, N - 1.0)
    _add_budgets(rows, core, at_arc)
    waiting = tangents.cost.wait(tangents.regions)[core.region]
    cost = {"t": np.ones(arcs), "ahead": waiting, "back": waiting}
    low = {"arrive": np.full(N, own[:, 0].min()), "leave": np.full(N, own[:, 0].min()), "e": np.full(arcs, -step_m)}
    high = {
        "delta": np.ones(arcs),
        "arrive": np.full(N, own[:, 1].max()),
        "leave": np.full(N, own[:, 1].max()),
        "waits": np.full(N, N - 1.0),
        "e": np.full(arcs, step_m),
    }
    program = rows.program(cost, low, high, integer=("delta", "waits"))
    return TravelProgram(program, core, rows.columns("leave"), rows.columns("arrive"), rows.columns("e"))


def _add_budgets(rows: Blocks, core: Core, at_arc: csc_array) -> None:
    """Add a row per budget; where travel along X counts, a column per step for |sum of e|."""
    for budget, used in zip(core.budgets, core.used, strict=True):
        blocks = {"delta": csc_array(used[None])}
        if budget.travels:
            changes = at_arc.shape[0]
            eye = csc_array(np.eye(changes))
            rows.widen("change", changes)
            for sign in (1.0, -1.0):
                rows.add({"e": sign * at_arc, "change": eye}, 0.0, np.inf)
            by_waits = csc_array(np.ones((1, len(core.step))))
            blocks |= {"change": csc_array(np.ones((1, changes))), "ahead": by_waits, "back": by_waits}
        rows.add(blocks, -np.inf, budget.limit)


def _ones(row: IntArray, column: IntArray, shape: tuple[int, int]) -> csc_array:
    return csc_array((np.ones(len(row)), (row, column)), shape=shape)
