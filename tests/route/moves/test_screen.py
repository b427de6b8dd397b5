"""What is known of moves, and handed on to problems with other ends."""

import numpy as np

from pipeline.arrays import IntArray
from pipeline.route.moves.candidates import Moves
from pipeline.route.moves.rejections import BRANCH_REJECTIONS, Rejection
from pipeline.route.moves.screen import Screen

BAD = BRANCH_REJECTIONS[0]
ROWS = 6
"""Four regions, then start and goal."""


class Follower:
    """Rejects moves to region 2 and from the start, and notes what it was asked."""

    def __init__(self) -> None:
        self.asked: set[tuple[int, int]] = set()

    def __call__(self, source: IntArray, target: IntArray) -> list[Rejection | None]:
        """Follow moves."""
        pairs = list(zip(source.tolist(), target.tolist(), strict=True))
        self.asked.update(pairs)
        return [BAD if 2 in pair or 4 in pair else None for pair in pairs]


def test_what_is_learned_holds_between_regions_only() -> None:
    """Moves of start and goal, which are others in another problem, are followed again; no other move is."""
    moves = Moves(np.array([0, 0, 1, 4, 3]), np.array([1, 2, 3, 0, 5]))
    everything = np.arange(ROWS)
    first, second = Follower(), Follower()
    before = Screen(first, ROWS)
    assert len(before.screen(moves, moves, everything)) == 3
    after = Screen(second, ROWS)
    after.learn(before)
    assert len(after.without_bad(moves, everything)) == 4
    assert len(after.screen(moves, moves, everything)) == 3
    assert first.asked == {(0, 1), (0, 2), (1, 3), (0, 4), (3, 5)}
    assert second.asked == {(0, 4), (3, 5)}
    assert before.rejections == after.rejections
