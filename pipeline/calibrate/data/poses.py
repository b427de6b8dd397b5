"""Poses as they were measured: what encoders showed, and where reflectors were seen.

Of a machine that stood still that is a row of numbers. Of one that moved along a known motion it is a time: the tracker
shows t where the controller is at t - tau, and the clock offset tau of each motion is not known.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.calibrate.data.motions import DrivenMotion

_STATIC = -1


@dataclass(frozen=True, eq=False)
class Timing:
    """When rows were measured that belong to motions.

    Attributes
    ----------
    driven : DrivenMotion
        What was driven, by all of these motions.
    motion : (n,)
        Number of the motion of every row, from 0; -1 where the machine stood still.
    t_s : (n,)
        Time by the clock of the tracker, from where that takes the motion to begin; NaN where the machine stood still.
    """

    driven: DrivenMotion
    motion: IntArray
    t_s: FloatArray


@dataclass(frozen=True, eq=False)
class StaticPoses:
    """Measured poses, of a machine that stood still or moved.

    Attributes
    ----------
    q_m : (n, 5)
        What the encoders of c1, c2, c3, l2b, l3b showed; of motions, if clocks agree.
    seen_m : (n, reflectors, 3)
        Reflectors in the frame of the tracker; NaN where one was not seen.
    place : callable
        Says where a row is, for messages: file and line.
    timing : Timing or None
        When rows of motions were measured; None where the machine always stood still.
    """

    q_m: FloatArray
    seen_m: FloatArray
    place: Callable[[int], str] = lambda row: f"row {row}"
    timing: Timing | None = None

    def __len__(self) -> int:
        return len(self.q_m)

    @property
    def is_seen(self) -> BoolArray:
        """Which reflectors were seen. Shape (n, reflectors)."""
        return np.asarray(np.isfinite(self.seen_m).all(axis=2))

    def at(self, rows: IntArray) -> "StaticPoses":
        """Pick rows."""
        timing = self.timing
        if timing is not None:
            timing = replace(timing, motion=timing.motion[rows], t_s=timing.t_s[rows])
        return replace(
            self,
            q_m=self.q_m[rows],
            seen_m=self.seen_m[rows],
            place=lambda row: self.place(int(rows[row])),
            timing=timing,
        )

    @property
    def motions(self) -> int:
        """Number of motions, each with a clock offset of its own."""
        return 0 if self.timing is None else int(self.timing.motion.max(initial=_STATIC)) + 1

    @property
    def is_moving(self) -> BoolArray:
        """Which rows belong to motions. Shape (n,)."""
        return np.zeros(len(self), dtype=bool) if self.timing is None else self.timing.motion != _STATIC

    def times_s(self, clocks_s: FloatArray) -> FloatArray:
        """Give the times of the controller at rows of motions, with clock offsets (motions,). Shape (moving,)."""
        assert self.timing is not None, "only motions have times"
        moving = self.is_moving
        return np.asarray(self.timing.t_s[moving] - clocks_s[self.timing.motion[moving]])

    def encoders(self, clocks_s: FloatArray) -> FloatArray:
        """Give what encoders showed, with clock offsets (motions,). Shape (n, 5)."""
        if self.timing is None:
            return self.q_m
        q = self.q_m.copy()
        q[self.is_moving] = self.timing.driven.encoders(self.times_s(clocks_s))
        return q

    def encoder_rates(self, clocks_s: FloatArray) -> FloatArray:
        """Give how fast that changes; zero where the machine stood still. Shape (n, 5)."""
        rates = np.zeros_like(self.q_m)
        if self.timing is not None:
            rates[self.is_moving] = self.timing.driven.encoder_rates(self.times_s(clocks_s))
        return rates

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
