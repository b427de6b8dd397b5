"""Static poses as they were measured: what encoders showed, and where reflectors were seen."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class StaticPoses:
    """Measured poses.

    Attributes
    ----------
    q_m : (n, 5)
        What the encoders of c1, c2, c3, l2b, l3b showed.
    seen_m : (n, reflectors, 3)
        Reflectors in the frame of the tracker; NaN where one was not seen.
    place : callable
        Says where a row is, for messages: file and line.
    """

    q_m: FloatArray
    seen_m: FloatArray
    place: Callable[[int], str] = lambda row: f"row {row}"

    def __len__(self) -> int:
        return len(self.q_m)

    @property
    def is_seen(self) -> BoolArray:
        """Which reflectors were seen. Shape (n, reflectors)."""
        return np.asarray(np.isfinite(self.seen_m).all(axis=2))

    def at(self, rows: IntArray) -> "StaticPoses":
        """Pick rows."""
        return replace(self, q_m=self.q_m[rows], seen_m=self.seen_m[rows], place=lambda row: self.place(int(rows[row])))

    def joined(self, other: "StaticPoses") -> "StaticPoses":
        """Add the rows of another measurement with the same reflectors."""
        own = len(self)
        return StaticPoses(
            np.concatenate([self.q_m, other.q_m]),
            np.concatenate([self.seen_m, other.seen_m]),
            lambda row: self.place(row) if row < own else other.place(row - own),
        )

    def without(self, rejected: BoolArray) -> "StaticPoses":
        """Take points (n, reflectors) for not seen."""
        return replace(self, seen_m=np.where(rejected[..., None], np.nan, self.seen_m))
