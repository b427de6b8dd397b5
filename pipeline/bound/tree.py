"""Proofs as trees: which boxes were halved where, and which of their leaves hold no pose that matters.

Only the wall is kept: excluded leaves beside the component of the start. All other leaves may hold anything, and where
both halves of a box do, the box does.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, IntArray
from pipeline.bound.boxes import CELLS
from pipeline.bound.chart import ALPHA, BETA
from pipeline.bound.flood import Flood

OPEN, EXCLUDED = 6, 7
"""Codes of leaves; those of nodes that were halved are the coordinates 0 to 5."""
_COORDINATES = 6


@dataclass(frozen=True, eq=False)
class Tree:
    """A tree of boxes in preorder.

    Attributes
    ----------
    codes : (n,)
        The coordinate that was halved, or `OPEN` or `EXCLUDED` for leaves.
    low, high : (6, n)
        Bounds on the lattice.
    first, second : (n,)
        Children; those of leaves are 0.
    """

    codes: IntArray
    low: IntArray
    high: IntArray
    first: IntArray
    second: IntArray

    @property
    def at_edge(self) -> BoolArray:
        """Nodes that touch a face of the chart behind which it goes on."""
        touches = [(self.low[k] == 0) | (self.high[k] == CELLS) for k in (ALPHA, BETA)]
        return np.asarray(touches[0] | touches[1])


def proof_codes(found: Flood) -> IntArray:
    """Encode the proof of a flood: preorder codes (n,)."""
    boxes = found.boxes
    n = boxes.count
    axis, child = boxes.axis[:n].astype(int), boxes.child[:n].astype(int)
    leaf = axis < 0
    component = np.zeros(n, dtype=bool)
    component[found.component] = True
    excluded = boxes.excluded & leaf
    first = np.where(leaf, 0, child)
    whole = Tree(np.where(leaf, OPEN, axis), boxes.low[:, :n], boxes.high[:, :n], first, np.where(leaf, 0, child + 1))
    wall = np.zeros(n, dtype=bool)
    wall[touching(whole, component, excluded)[1]] = True
    if (whole.at_edge & component).any():
        wall |= whole.at_edge & excluded
    wall[boxes.holding(found.start, np.flatnonzero(excluded))] = True
    return _merged(axis.tolist(), child.tolist(), wall)


def _merged(axis: list[int], child: list[int], wall: BoolArray) -> IntArray:
    holds = wall.tolist()
    for node in range(len(axis) - 1, -1, -1):
        if axis[node] >= 0:
            holds[node] = holds[child[node]] or holds[child[node] + 1]
    codes, stack = [], [0]
    while stack:
        node = stack.pop()
        if axis[node] >= 0 and holds[node]:
            codes.append(axis[node])
            stack += [child[node] + 1, child[node]]
        else:
            codes.append(EXCLUDED if holds[node] else OPEN)
    return np.array(codes)


def read_tree(codes: IntArray, free: list[int]) -> Tree:
    """Rebuild a tree from its codes.

    Raises
    ------
    ValueError
        If they are not those of one tree, or boxes are halved where they cannot be.
    """
    n = len(codes)
    low, high = np.zeros((_COORDINATES, n), dtype=np.int64), np.zeros((_COORDINATES, n), dtype=np.int64)
    first, second = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    corner = ([0] * _COORDINATES, [CELLS if k in free else 0 for k in range(_COORDINATES)])
    stack: list[tuple[list[int], list[int], int]] = [(*corner, -1)]
    lows, highs = [], []
    for node, code in enumerate(codes.tolist()):
        if not stack:
            raise ValueError("the tree ends before its codes do")
        below, above, parent = stack.pop()
        lows.append(below)
        highs.append(above)
        if parent >= 0:
            second[parent] = node
        if code < _COORDINATES:
            middle, odd = divmod(below[code] + above[code], 2)
            if code not in free or odd or above[code] - below[code] < 2:
                raise ValueError(f"node {node} is halved along coordinate {code}, which it cannot be")
            first[node] = node + 1
            stack.append(([*below[:code], middle, *below[code + 1 :]], above, node))
            stack.append((below, [*above[:code], middle, *above[code + 1 :]], -1))
        elif code not in (OPEN, EXCLUDED):
            raise ValueError(f"node {node} has the unknown code {code}")
    if stack:
        raise ValueError("the codes end before the tree does")
    low[:], high[:] = np.array(lows).T, np.array(highs).T
    return Tree(codes, low, high, first, second)


def touching(tree: Tree, some: BoolArray, others: BoolArray) -> tuple[IntArray, IntArray]:
    """Find all pairs of a leaf of `some` (n,) and one of `others` (n,) with a common face. Two arrays (pairs,)."""
    holds_some, holds_others = (_upwards(tree, flags) for flags in (some, others))
    a, b = np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64)
    found_a, found_b = [], []
    leaf = tree.codes >= _COORDINATES
    size = (tree.high - tree.low).sum(axis=0)
    while a.size:
        keep = holds_some[a] & holds_others[b] & _meet(tree, a, b)
        a, b = a[keep], b[keep]
        done = leaf[a] & leaf[b]
        found_a.append(a[done & (a != b)])
        found_b.append(b[done & (a != b)])
        a, b = a[~done], b[~done]
        open_a = leaf[b] | (~leaf[a] & (size[a] >= size[b]))
        same = a == b
        parts = []
        for child in (tree.first, tree.second):
            parts.append((child[a[open_a & ~same]], b[open_a & ~same]))
            parts.append((a[~open_a & ~same], child[b[~open_a & ~same]]))
            parts += [(child[a[same]], other[a[same]]) for other in (tree.first, tree.second)]
        a, b = (np.concatenate([part[k] for part in parts]) for k in range(2))
    return np.concatenate(found_a), np.concatenate(found_b)


def _upwards(tree: Tree, flags: BoolArray) -> BoolArray:
    """Mark all nodes that hold a marked leaf; children come after their parents."""
    holds = (flags & (tree.codes >= _COORDINATES)).tolist()
    codes, first, second = tree.codes.tolist(), tree.first.tolist(), tree.second.tolist()
    for node in range(len(holds) - 1, -1, -1):
        if codes[node] < _COORDINATES:
            holds[node] = holds[first[node]] or holds[second[node]]
    return np.array(holds)


def _meet(tree: Tree, a: IntArray, b: IntArray) -> BoolArray:
    low, high = np.maximum(tree.low[:, a], tree.low[:, b]), np.minimum(tree.high[:, a], tree.high[:, b])
    fixed = (tree.low[:, 0] == tree.high[:, 0])[:, None]
    return np.asarray((low <= high).all(axis=0) & (((low == high) & ~fixed).sum(axis=0) <= 1))
