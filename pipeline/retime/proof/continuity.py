"""Whether a time law stays on its path, and how far it jumps between two pieces: coefficients are rounded to floats.

The values on both sides are those of the exact polynomials. A law found by a program of limited jerk jumps by some
1e-10 m, 1e-9 m/s and 1e-7 m/s^2.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_poly, fmpq

from pipeline.arrays import FloatArray
from pipeline.inclusion.condition import above
from pipeline.retime.proof.exact_motion import LEAST_PART, ExactMotion, about
from pipeline.retime.proof.polynomials import magnitude

_CONTINUOUS = 3
"""Position, velocity and, where jerk is limited, acceleration do not jump."""
_ALLOWED_M = 1e-8
"""Largest jump of a position that counts as rounding."""
_ALLOWED_PART = np.array([1e-5, 1e-4])
"""The same of velocity and acceleration, as parts of their largest values."""
_PASSED_BY = fmpq(1, 10**9)
"""How far s may pass the ends of the path by rounding."""


@dataclass(frozen=True, eq=False)
class Jumps:
    """The jumps of a motion.

    Attributes
    ----------
    largest : (3,)
        Largest jumps of position, velocity and acceleration of any actuator, in metres and seconds.
    allowed : (3,)
        What counts as rounding.
    t_s : (3,)
        Where they are: seconds since the beginning of the motion.
    """

    largest: FloatArray
    allowed: FloatArray
    t_s: FloatArray


def find_jumps(motion: ExactMotion, peaks: FloatArray) -> Jumps:
    """Bound the jumps of a motion whose largest velocity and acceleration are `peaks` (2,)."""
    ends = [(piece.begins, about(piece, fmpq(0)), about(piece, piece.length)) for piece in motion.law]
    before, largest, t_s = _at_rest(motion, at_goal=False), np.zeros(_CONTINUOUS), np.zeros(_CONTINUOUS)
    after = [(begins, _values(motion, first), _values(motion, last)) for begins, first, last in ends]
    over = float(motion.law[-1].begins) + float(arb(motion.law[-1].length).mid())
    for begins, first, last in [*after, (over, _at_rest(motion, at_goal=True), before)]:
        jump = np.array(
            [
                [above((a - b).abs_upper()) for a, b in zip(*pair, strict=True)]
                for pair in zip(before, first, strict=True)
            ]
        ).max(axis=1)
        t_s, largest = np.where(jump > largest, begins, t_s), np.maximum(largest, jump)
        before = last
    return Jumps(largest, np.concatenate([[_ALLOWED_M], _ALLOWED_PART * peaks]), t_s)


def _at_rest(motion: ExactMotion, *, at_goal: bool) -> list[list[arb]]:
    """Give positions at an end of the path, and no velocities and accelerations."""
    return _values(motion, arb_poly([arb(int(at_goal))]))


def _values(motion: ExactMotion, s: arb_poly) -> list[list[arb]]:
    """Evaluate positions, velocities and accelerations of all actuators where s is at u = 0, (3, 5).

    At a knot, where they are the same on either side, those of the piece after it.
    """
    piece = motion.covering(s(arb(0)))[-1]
    rows = []
    for actuator in range(len(motion.actuators[piece])):
        values = motion.position(piece, actuator, s).coeffs()[:_CONTINUOUS]
        rows.append([values[n] * (2 if n == 2 else 1) if n < len(values) else arb(0) for n in range(_CONTINUOUS)])
    return [list(column) for column in zip(*rows, strict=True)]


def leaves_path(motion: ExactMotion) -> float | None:
    """Return a time from which on s is not proven to be on the path, to within 1e-9; None if it is throughout."""
    half_way, reach = arb(0.5), arb(fmpq(1, 2) + _PASSED_BY)
    for piece in motion.law:
        waiting = [(fmpq(0), piece.length)]
        while waiting:
            begins, ends = waiting.pop()
            middle = (begins + ends) / 2
            if magnitude(about(piece, middle) - half_way, arb((ends - begins) / 2)) <= reach:
                continue
            if ends - begins <= LEAST_PART * piece.length:
                return piece.begins + float(arb(begins).mid())
            waiting += [(middle, ends), (begins, middle)]
    return None
