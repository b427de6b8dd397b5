"""Floods: whether boxes that are not excluded join start and goal, halving those on the cheapest ways between them.

Excluded boxes hold no pose within the limits with kappa <= K. The others form a graph by their common faces. A path
that keeps the limits and kappa <= K runs through boxes of one component: where it meets an edge or corner, all boxes
around that are in the graph, and joined by faces. So a component that holds the start but not the goal proves that
there is no such path. That start and goal are in one component proves nothing.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.bound.boxes import Boxes
from pipeline.bound.evaluate import Evaluator
from pipeline.bound.graph import FAR, Graph
from pipeline.progress import QUIET, Monitor

_FIRST_WIDTH = 1.2
"""Boxes are halved to this width first of all, in radians or metres."""
_WIDE, _SMALL = 2.0, 0.06
"""Boxes with kappa <= K in their middle are taken for passable by the search, not by proofs: at first also wide ones,
and smaller and smaller ones whenever those join start and goal."""
_ASPECT = 4.0


class Verdict(StrEnum):
    """What a flood ends with."""

    NONE = "no path"
    OPEN = "not excluded"
    LATE = "undecided"


@dataclass(frozen=True, eq=False)
class Flood:
    """The end of a flood.

    Attributes
    ----------
    verdict : Verdict
        `NONE` is proven; the others prove nothing.
    boxes : Boxes
        The tree.
    component : (n,)
        Leaves that can be reached from the start.
    rounds : int
        How often boxes on the cheapest ways were halved.
    start : (6,)
        The start.
    """

    verdict: Verdict
    boxes: Boxes
    component: IntArray
    rounds: int
    start: FloatArray


def flood(
    evaluator: Evaluator, start: FloatArray, goal: FloatArray, most_boxes: int, monitor: Monitor = QUIET
) -> Flood:
    """Try to prove that no path from start to goal (6,) has kappa <= K, with at most so many boxes."""
    boxes = Boxes(evaluator)
    _refine(boxes, _FIRST_WIDTH)
    active = np.flatnonzero(~boxes.excluded & (boxes.axis[: boxes.count] < 0))
    sources = [boxes.holding(point, active) for point in (start, goal)]
    rounds, width = 0, _WIDE
    while True:
        passable = (boxes.widths(active).max(axis=0) <= width) & (boxes.middle[active] <= evaluator.target)
        graph = Graph(active, boxes.edges, boxes.at_edge(active), passable)
        there, back = (graph.distances(some) for some in sources)
        component = there < FAR
        total = np.where(component & (back < FAR), there + back - ~passable, FAR)
        best = int(total.min(initial=FAR))
        if best == 0 and width > _SMALL:
            width *= 0.5
            continue
        if best in (0, FAR):
            return Flood(Verdict.OPEN if best == 0 else Verdict.NONE, boxes, active[component], rounds, start)
        chosen = ~passable & (total == best)
        nodes = active[chosen]
        monitor.progress(f"{boxes.count:,} boxes, {best} between start and goal, {len(nodes):,} to halve")
        if boxes.count + 2 * len(nodes) > most_boxes:
            return Flood(Verdict.LATE, boxes, active[component], rounds, start)
        before = boxes.count
        boxes.halve(nodes, _axes(boxes, nodes))
        halves = np.arange(before, boxes.count)
        halves = halves[~boxes.excluded[halves]]
        kept = active[component & ~chosen]
        sources = [
            boxes.holding(point, np.concatenate([np.intersect1d(some, kept), halves]))
            for point, some in zip((start, goal), sources, strict=True)
        ]
        active = np.concatenate([kept, halves])
        rounds += 1


def _refine(boxes: Boxes, width: float) -> None:
    """Halve all boxes that are not excluded until none is wider."""
    leaves = np.arange(1)
    while leaves.size:
        leaves = leaves[~boxes.excluded[leaves]]
        widths = boxes.widths(leaves)
        leaves = leaves[widths.max(axis=0) > width]
        before = boxes.count
        boxes.halve(leaves, boxes.widths(leaves).argmax(axis=0))
        leaves = np.arange(before, boxes.count)


def _axes(boxes: Boxes, nodes: IntArray) -> IntArray:
    """Choose the coordinate that promises most, unless the box is much longer than wide."""
    widths = boxes.widths(nodes)
    axes = boxes.weights[:, nodes].argmax(axis=0)
    longest = widths.argmax(axis=0)
    rows = np.arange(len(nodes))
    slim = widths[longest, rows] > _ASPECT * widths[axes, rows]
    return np.asarray(np.where(slim, longest, axes))
