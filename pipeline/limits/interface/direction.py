"""Limits that depend on the direction in which the actuators move.

Directions are signs of the actuators' velocities, zero for one that stands still.
"""

from typing import Protocol, runtime_checkable

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.machine.samples import PoseSamples


@runtime_checkable
class DirectedLimit(Protocol):
    """A limit with margins that count in one direction of motion only."""

    def applies(self, directions: FloatArray) -> BoolArray:
        """Which margins count at n poses passed in `directions` (n, 5). Shape (n, m)."""

    def blocked(self, samples: PoseSamples) -> BoolArray:
        """In which directions no actuator can move at n poses: positive, negative. Shape (n, 5, 2)."""


def applying(limit: object, directions: FloatArray) -> BoolArray:
    """Tell which margins of a limit count at n poses passed in `directions` (n, 5). Shape (n, m), or (n, 1) for all."""
    if isinstance(limit, DirectedLimit):
        return limit.applies(directions)
    return np.ones((len(directions), 1), dtype=bool)


def end_stretches(blocked: BoolArray) -> BoolArray:
    """Keep of what is blocked at samples of a path (n, ...) the stretches that begin at the start, or end at the goal.

    The poses of start and goal are given: near them, the direction of motion has to change, not the pose.
    """
    from_start = np.logical_and.accumulate(blocked, axis=0)
    to_goal = np.logical_and.accumulate(blocked[::-1], axis=0)[::-1]
    return np.asarray(from_start | to_goal, dtype=bool)


def counting(limit: object, samples: PoseSamples, directions: FloatArray) -> BoolArray:
    """Tell which values of a limit the samples (n,) of a path have to keep by their pose. Shape (n, m), or (n, 1).

    What counts at a sample counts at its neighbours, too, since directions change in between. Directions that are
    blocked from the start on, or up to the goal, are not taken at all, and their margins do not count.
    """
    if not isinstance(limit, DirectedLimit):
        return applying(limit, directions)
    positive, negative = np.moveaxis(end_stretches(limit.blocked(samples)), -1, 0)
    last = len(directions) - 1
    counts = np.zeros(1, dtype=bool)
    for shift in (-1, 0, 1):
        beside = directions[np.clip(np.arange(last + 1) + shift, 0, last)]
        taken = np.where((positive & (beside > 0.0)) | (negative & (beside < 0.0)), 0.0, beside)
        counts = counts | limit.applies(taken)
    return counts
