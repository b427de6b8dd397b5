"""Screening: the moves of a core are followed before it is solved, each pair of regions once."""

from collections import Counter
from collections.abc import Callable

import numpy as np

from pipeline.arrays import IntArray
from pipeline.route.moves.candidates import Moves
from pipeline.route.moves.check import line_keys
from pipeline.route.moves.rejections import Rejection

Follow = Callable[[IntArray, IntArray], list[Rejection | None]]
"""Follows moves between rows (m,) of the region table; returns why each is rejected, None if it is not."""

Screening = Callable[[Moves, Moves, IntArray], Moves]
"""Follows the moves of a core (first), and leaves all known to be bad out of others (second); rows are mapped to
those of the region table by the third, (n,). `Screen.screen` is one."""


def keep_all(core: Moves, moves: Moves, base: IntArray) -> Moves:
    """Screen nothing: all moves are admissible."""
    return moves


class Screen:
    """What is known of moves followed so far, by rows of the region table.

    A move is as good as its reverse unless limits depend on the direction (`directed`).
    """

    def __init__(self, follow: Follow, regions: int, *, directed: bool = False) -> None:
        self._follow = follow
        self._regions = regions
        self._directed = directed
        self._known: dict[int, Rejection | None] = {}

    @property
    def followed(self) -> int:
        """How many different moves were followed."""
        return len(self._known)

    @property
    def rejections(self) -> Counter[Rejection]:
        """How many of them are rejected, by reason."""
        return Counter(found for found in self._known.values() if found is not None)

    @property
    def report(self) -> str:
        """The reasons in words."""
        return "; ".join(f"{count}: {reason}" for reason, count in sorted(self.rejections.items()))

    def screen(self, core: Moves, moves: Moves, base: IntArray) -> Moves:
        """Follow the moves of a core as far as they are not known, and leave all bad ones out of `moves`.

        `base` (n,) gives the row of the region table for the rows that both speak of.
        """
        keys = self._keys(base[core.source], base[core.target])
        unknown = np.array([key for key in np.unique(keys).tolist() if key not in self._known], dtype=np.int64)
        if len(unknown):
            found = self._follow(unknown // self._regions, unknown % self._regions)
            self._known.update(zip(unknown.tolist(), found, strict=True))
        return self.without_bad(moves, base)

    def forbid(self, source: int, target: int, rejection: Rejection) -> None:
        """Reject a move for a reason found otherwise."""
        self._known[int(self._keys(np.array([source]), np.array([target]))[0])] = rejection

    def learn(self, other: "Screen") -> None:
        """Take over what is known of a table with another start and another goal, of moves that neither takes part in.

        They are the last two rows of both tables, which are alike but for them.
        """
        ends = self._regions - 2
        for key, found in other._known.items():
            if max(divmod(key, self._regions)) < ends:
                self._known.setdefault(key, found)

    def without_bad(self, moves: Moves, base: IntArray) -> Moves:
        """Leave out the moves known to be bad; `base` as of `screen`."""
        bad = self._bad
        touched = np.zeros(self._regions, dtype=bool)
        touched[bad // self._regions] = touched[bad % self._regions] = True
        suspect = np.flatnonzero(touched[base][moves.source] & touched[base][moves.target])
        keep = np.ones(len(moves), dtype=bool)
        keep[suspect] = ~np.isin(self._keys(base[moves.source[suspect]], base[moves.target[suspect]]), bad)
        return moves if keep.all() else moves.take(keep)

    def _keys(self, source: IntArray, target: IntArray) -> IntArray:
        return line_keys(source, target, self._regions, directed=self._directed)

    @property
    def _bad(self) -> IntArray:
        return np.array([key for key, found in self._known.items() if found is not None], dtype=np.int64)
