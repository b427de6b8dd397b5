"""Where a path may not move an actuator one way: from the start on, or up to the goal, whose poses are given.

The derivative of a spline lies between the legs of its control polygon, so that legs which do not go one way keep the
spline from it.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.limits import DirectedLimit, end_stretches
from pipeline.machine.samples import PoseSamples
from pipeline.refine.splines import DEGREE


class OneWayLeg(NamedTuple):
    """A leg of the control polygon, from coefficient `leg` on, along which an actuator must not move one way (sign)."""

    leg: int
    actuator: int
    sign: float


def one_way_legs(
    limits: Iterable[object], samples: PoseSamples, s: FloatArray, knots: FloatArray
) -> tuple[OneWayLeg, ...]:
    """List the legs over which limits block a direction at the ends of a path, known at samples s (k,)."""
    first, last = knots[1 : -DEGREE - 1], knots[DEGREE + 1 : -1]
    found: set[OneWayLeg] = set()
    for limit in limits:
        if isinstance(limit, DirectedLimit):
            stretches = end_stretches(limit.blocked(samples))
            for at, actuator, side in np.argwhere(stretches).tolist():
                # Basis functions are zero at the ends of their supports; at start and goal the span beside them counts.
                inside = (first < s[at]) & (s[at] < last)
                beside = (first == s[at]) if at == 0 else (last == s[at]) & (at == len(s) - 1)
                legs = np.flatnonzero(inside | beside)
                found |= {OneWayLeg(leg, actuator, (1.0, -1.0)[side]) for leg in legs.tolist()}
    return tuple(sorted(found))
