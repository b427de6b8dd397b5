"""The boxes of a chart, halved again and again, and which of them have a face in common.

Bounds of boxes are whole numbers of a lattice, so that faces are compared exactly.
"""

from functools import partial

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.bound.chart import ALPHA, BETA
from pipeline.bound.evaluate import Evaluator
from pipeline.parallel import blocks, in_parallel

CELLS = 2**24
"""Cells of the lattice along each coordinate that is not fixed."""
_BATCH = 1024
_NEAR = 1e-7
"""Radians and metres: more than start and goal are off by rounding, also beside a fold, where it has a root's size."""


class Boxes:
    """A tree of boxes: node 0 is the domain, and every node that was halved has two children, one after the other.

    Attributes
    ----------
    chart : Chart
        Where the boxes are.
    low, high : (6, capacity)
        Bounds on the lattice.
    axis, child : (capacity,)
        The coordinate that was halved, -1 for leaves, and the first child.
    empty, middle, weights : (capacity,), (capacity,), (6, capacity)
        What `Evaluator` found; `excluded` are the empty ones.
    edges : (m, 2)
        Pairs of leaves that are not excluded and have a face in common.
    count : int
        Number of nodes.
    """

    def __init__(self, evaluator: Evaluator) -> None:
        chart = evaluator.chart
        self._evaluator = evaluator
        self.chart = chart
        self.low = np.zeros((6, 1), dtype=np.int32)
        self.high = np.where(chart.high > chart.low, CELLS, 0).astype(np.int32)[:, None]
        self.axis, self.child = np.full(1, -1, dtype=np.int8), np.full(1, -1, dtype=np.int32)
        self.empty, self.middle, self.weights = (
            np.zeros(1, dtype=bool),
            np.full(1, np.inf),
            np.ones((6, 1), dtype=np.float32),
        )
        self.edges = np.zeros((0, 2), dtype=np.int32)
        self.count = 1
        self._evaluate(np.array([0]))

    @property
    def excluded(self) -> BoolArray:
        """Nodes no pose of which is within the limits with kappa up to the target. Shape (count,)."""
        return self.empty[: self.count]

    def widths(self, nodes: IntArray) -> FloatArray:
        """Widths in radians and metres. Shape (6, n)."""
        scale = (self.chart.high - self.chart.low) / CELLS
        return np.asarray((self.high[:, nodes] - self.low[:, nodes]) * scale[:, None])

    def holding(self, point: FloatArray, nodes: IntArray) -> IntArray:
        """Those of some nodes (n,) that hold a point (6,), or are nearer than any rounding."""
        low, high = self._bounds(nodes)
        return nodes[((low <= point[:, None] + _NEAR) & (high >= point[:, None] - _NEAR)).all(axis=0)]

    def at_edge(self, nodes: IntArray) -> BoolArray:
        """Which of some nodes touch a face of the chart behind which it goes on. Shape (n,)."""
        touches = [(self.low[k, nodes] == 0) | (self.high[k, nodes] == CELLS) for k in (ALPHA, BETA)]
        return np.asarray(touches[0] | touches[1])

    def halve(self, nodes: IntArray, axes: IntArray) -> None:
        """Halve leaves (n,) along coordinates (n,), evaluate the halves, and join those that are not excluded."""
        if not nodes.size:
            return
        first = self.count + 2 * np.arange(len(nodes))
        self._grow(2 * len(nodes))
        self.axis[nodes], self.child[nodes] = axes, first
        middle = (self.low[axes, nodes] + self.high[axes, nodes]) // 2
        for k in range(2):
            self.low[:, first + k], self.high[:, first + k] = self.low[:, nodes], self.high[:, nodes]
        self.high[axes, first], self.low[axes, first + 1] = middle, middle
        self.count += 2 * len(nodes)
        self._evaluate(np.arange(self.count - 2 * len(nodes), self.count))
        self._join(first)

    def _join(self, first: IntArray) -> None:
        """Replace the edges of nodes that were halved."""
        alive = ~self.excluded
        moved = self.axis[: self.count][self.edges] >= 0
        affected = moved.any(axis=1)
        pairs = self.edges[affected]
        options = []
        for one in (0, 1):
            a = np.where(moved[affected, 0], self.child[pairs[:, 0]] + one, pairs[:, 0])
            rows_a = moved[affected, 0] | (one == 0)
            for other in (0, 1):
                b = np.where(moved[affected, 1], self.child[pairs[:, 1]] + other, pairs[:, 1])
                rows = rows_a & (moved[affected, 1] | (other == 0))
                rows &= alive[a] & alive[b]
                options.append(np.stack([a[rows], b[rows]], axis=1))
        options.append(np.stack([first, first + 1], axis=1)[alive[first] & alive[first + 1]])
        found = np.concatenate(options)
        found = found[self._touch(found[:, 0], found[:, 1])]
        self.edges = np.concatenate([self.edges[~affected], found.astype(np.int32)])

    def _touch(self, a: IntArray, b: IntArray) -> BoolArray:
        """Whether pairs of boxes have a face in common, or at least more than an edge."""
        touching, faces = np.ones(len(a), dtype=bool), np.zeros(len(a), dtype=np.int8)
        for k in self.chart.free:
            low, high = np.maximum(self.low[k, a], self.low[k, b]), np.minimum(self.high[k, a], self.high[k, b])
            touching &= low <= high
            faces += low == high
        return touching & (faces <= 1)

    def _bounds(self, nodes: IntArray | slice) -> tuple[FloatArray, FloatArray]:
        start = self.chart.low[:, None]
        scale = (self.chart.high - self.chart.low)[:, None] / CELLS
        return start + scale * self.low[:, nodes], start + scale * self.high[:, nodes]

    def _evaluate(self, nodes: IntArray) -> None:
        parts = [nodes[rows] for rows in blocks(len(nodes), _BATCH)]
        tasks = [partial(self._evaluator, *self._bounds(some)) for some in parts]
        found = in_parallel(tasks) if len(tasks) > 1 else (task() for task in tasks)
        for some, one in zip(parts, found, strict=True):
            self.empty[some], self.middle[some], self.weights[:, some] = one.excluded, one.middle, one.weights

    def _grow(self, more: int) -> None:
        capacity = len(self.axis)
        if self.count + more <= capacity:
            return
        extra = max(more, capacity)
        for name, fill in (
            ("low", 0),
            ("high", 0),
            ("axis", -1),
            ("child", -1),
            ("empty", 0),
            ("middle", 0),
            ("weights", 0),
        ):
            old = getattr(self, name)
            new = np.full((*old.shape[:-1], extra), fill, dtype=old.dtype)
            setattr(self, name, np.concatenate([old, new], axis=-1))
