"""Bounds of velocity, acceleration and jerk that hold at every instant of a motion.

Values at the middles of intervals are attained. An interval is halved while its bound is farther than a little above
the largest value attained so far: the largest value is known from both sides.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from flint import arb, fmpq

from pipeline.arrays import FloatArray
from pipeline.inclusion.condition import above, below
from pipeline.retime.proof.exact_motion import LEAST_PART, ExactMotion, LawPiece, about
from pipeline.retime.proof.polynomials import enclosure, magnitude

ORDERS = 3
"""Velocity, acceleration, jerk."""
_SHARP = 4e-4
"""How far a bound may be above the largest value attained, relatively."""
_ROOM = 1e-5
"""Attained at most this part below a limit, it is not proven to hold: other arithmetic needs some room to verify it."""
_FLOOR = 1e-6
"""Part of a limit below which no bound need be sharp."""


@dataclass(frozen=True, eq=False)
class KinematicUse:
    """Fractions of the limits that a motion uses, rows velocity, acceleration, jerk and a column per actuator.

    Attributes
    ----------
    proven : (3, 5)
        No instant uses more.
    attained : (3, 5)
        Some instant uses as much.
    t_s, s : (3, 5)
        Where that is: seconds since the beginning of the motion, and path parameter.
    intervals : int
        Intervals of time that prove it.
    """

    proven: FloatArray
    attained: FloatArray
    t_s: FloatArray
    s: FloatArray
    intervals: int


@dataclass(frozen=True, eq=False)
class _Interval:
    """An interval of time within a piece of the law, by its beginning and its end."""

    piece: LawPiece
    begins: fmpq
    ends: fmpq


def kinematic_use(motion: ExactMotion, limits: FloatArray) -> KinematicUse:
    """Bound the use of limits (3, 5), infinite where there is none, at every instant of a motion.

    What cannot be bounded within intervals of a 2^-24th of a piece is proven only as far as it is. What is no number,
    as for a limit that is none, counts as infinite.
    """
    attained, proven, t_s, s = (np.zeros(limits.shape) for _ in range(4))
    waiting, count = [_Interval(piece, fmpq(0), piece.length) for piece in motion.law], 0
    while waiting:
        found = [_bound(motion, interval, limits) for interval in waiting]
        for use in found:
            larger = use.attained > attained
            attained = np.where(larger, use.attained, attained)
            t_s, s = np.where(larger, use.t_s, t_s), np.where(larger, use.s, s)
        goal, halved = goals(attained), list[_Interval]()
        for interval, use in zip(waiting, found, strict=True):
            if (use.bound > goal).any() and interval.ends - interval.begins > LEAST_PART * interval.piece.length:
                halved += _halves(interval)
            else:
                proven, count = np.maximum(proven, use.bound), count + 1
        waiting = halved
    # Bounds that were good enough are stated as such, so that other arithmetic has room to verify them.
    return KinematicUse(np.maximum(proven, goals(attained)), attained, t_s, s, count)


def goals(attained: FloatArray) -> FloatArray:
    """Give the bounds that are good enough for the largest values attained: one wherever that is still above them."""
    sharp = np.maximum((1.0 + _SHARP) * attained, _FLOOR)
    return np.where(attained <= 1.0 - _ROOM, np.minimum(sharp, 1.0), sharp)


def _number(value: float) -> float:
    """Give infinity for what is no number: compared, that would count as nothing."""
    return np.inf if np.isnan(value) else value


def _halves(interval: _Interval) -> Iterator[_Interval]:
    middle = (interval.begins + interval.ends) / 2
    yield _Interval(interval.piece, interval.begins, middle)
    yield _Interval(interval.piece, middle, interval.ends)


@dataclass(frozen=True, eq=False)
class _Use:
    """The use over an interval (3, 5): a bound, and what its middle attains, at t and s."""

    bound: FloatArray
    attained: FloatArray
    t_s: float
    s: float


def _bound(motion: ExactMotion, interval: _Interval, limits: FloatArray) -> _Use:
    """Bound the use of limits over an interval."""
    middle, half = (interval.begins + interval.ends) / 2, arb((interval.ends - interval.begins) / 2)
    s = about(interval.piece, middle)
    at_middle, everywhere = s(arb(0)), enclosure(s, half)
    bound, values = np.zeros(limits.shape), np.zeros(limits.shape)
    holds = motion.covering(at_middle)
    for piece in motion.covering(everywhere):
        for actuator in range(limits.shape[1]):
            f = motion.position(piece, actuator, s)
            for order in range(ORDERS):
                f = f.derivative()
                limit = limits[order, actuator]
                if np.isinf(limit):
                    continue
                bound[order, actuator] = max(bound[order, actuator], _number(above(magnitude(f, half) / arb(limit))))
                # At a knot it is not known which piece holds the middle.
                if len(holds) == 1 and piece == holds[0]:
                    values[order, actuator] = max(0.0, _number(below(f(arb(0)).abs_lower() / arb(limit))))
    return _Use(bound, values, interval.piece.begins + float(arb(middle).mid()), float(at_middle.mid()))
