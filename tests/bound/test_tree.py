"""Tests of proofs as trees: read back as they were, with all faces found."""

from itertools import combinations

import numpy as np
import pytest

from pipeline.bound.boxes import CELLS
from pipeline.bound.tree import EXCLUDED, OPEN, read_tree, touching

FREE = [0, 1, 4]


def _random_codes(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)

    def grow(depth: int) -> list[int]:
        if depth == 0 or rng.random() < 0.15:
            return [int(rng.choice([OPEN, EXCLUDED]))]
        return [int(rng.choice(FREE)), *grow(depth - 1), *grow(depth - 1)]

    return np.array(grow(6))


@pytest.mark.parametrize("seed", range(4))
def test_leaves_tile_the_domain_and_faces_are_found(seed: int):
    """Volumes add up, and pairs with a common face are those of brute force."""
    tree = read_tree(_random_codes(seed), FREE)
    leaves = np.flatnonzero(tree.codes >= OPEN)
    sides = (tree.high - tree.low)[FREE][:, leaves] / CELLS
    assert sides.prod(axis=0).sum() == 1.0
    expected = set()
    for a, b in combinations(leaves.tolist(), 2):
        low, high = np.maximum(tree.low[:, a], tree.low[:, b])[FREE], np.minimum(tree.high[:, a], tree.high[:, b])[FREE]
        if (low <= high).all() and (low == high).sum() == 1 and tree.codes[a] != tree.codes[b]:
            expected.add((a, b) if tree.codes[a] == OPEN else (b, a))
    found = list(
        zip(*(part.tolist() for part in touching(tree, tree.codes == OPEN, tree.codes == EXCLUDED)), strict=True)
    )
    assert len(found) == len(set(found))
    assert set(found) == expected


@pytest.mark.parametrize(
    ("codes", "message"),
    [([0, OPEN], "codes end"), ([OPEN, OPEN], "tree ends"), ([2, OPEN, OPEN], "cannot be"), ([9], "unknown code")],
)
def test_what_is_no_tree_is_refused(codes: list[int], message: str):
    """Codes that end early or late, or halve what is fixed, are named."""
    with pytest.raises(ValueError, match=message):
        read_tree(np.array(codes), FREE)


def test_halving_ends_with_the_lattice():
    """A cell of the lattice cannot be halved."""
    with pytest.raises(ValueError, match="cannot be"):
        read_tree(np.array([0] * 40), FREE)
