"""Tests of the tree of boxes: leaves tile the domain, and edges are all common faces."""

from itertools import combinations

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.bound.boxes import CELLS, Boxes
from pipeline.bound.evaluate import Evaluation, Evaluator


class _Anything(Evaluator):
    """Evaluates nothing, and excludes some boxes at random."""

    def __call__(self, low: FloatArray, high: FloatArray) -> Evaluation:
        n = low.shape[1]
        return Evaluation(np.random.default_rng(n).random(n) < 0.2, np.full(n, 5.0), high - low)


def _halved(evaluator: Evaluator) -> Boxes:
    rng = np.random.default_rng(1)
    boxes = Boxes(_Anything(evaluator.chart, evaluator.sign, evaluator.target))
    boxes.empty[0] = False
    for _ in range(7):
        leaves = np.flatnonzero((boxes.axis[: boxes.count] < 0) & ~boxes.excluded)
        some = leaves[rng.random(len(leaves)) < 0.9]
        boxes.halve(some, rng.choice(evaluator.chart.free, len(some)))
    return boxes


def test_leaves_tile_the_domain(evaluator: Evaluator):
    """Their volumes add up to that of the domain, and parents hold their children."""
    boxes = _halved(evaluator)
    leaves = np.flatnonzero(boxes.axis[: boxes.count] < 0)
    volumes = ((boxes.high - boxes.low)[:, leaves] / CELLS).prod(axis=0)
    assert len(leaves) > 20
    assert volumes.sum() == 1.0


def test_edges_are_the_common_faces(evaluator: Evaluator):
    """Every pair of leaves that are not excluded is an edge if and only if they share a face."""
    boxes = _halved(evaluator)
    leaves = np.flatnonzero((boxes.axis[: boxes.count] < 0) & ~boxes.excluded)
    expected = set()
    for a, b in combinations(leaves.tolist(), 2):
        low = np.maximum(boxes.low[:, a], boxes.low[:, b])
        high = np.minimum(boxes.high[:, a], boxes.high[:, b])
        if (low <= high).all() and (low == high).sum() == 1:
            expected.add((a, b))
    found = [tuple(sorted(edge)) for edge in boxes.edges.tolist()]
    assert len(found) == len(set(found))
    assert set(found) == expected


def test_points_are_held_by_all_leaves_around_them(evaluator: Evaluator):
    """A point on a common face is held by both boxes."""
    boxes = Boxes(_Anything(evaluator.chart, evaluator.sign, evaluator.target))
    boxes.empty[0] = False
    boxes.halve(np.array([0]), np.array([0]))
    middle = 0.5 * (evaluator.chart.low + evaluator.chart.high)
    assert boxes.holding(middle, np.array([1, 2])).tolist() == [1, 2]
    assert boxes.holding(middle + 0.1, np.array([1, 2])).tolist() == [2]
