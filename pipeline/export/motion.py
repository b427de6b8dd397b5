"""A sampled motion of the actuators: what every export format is written from and read back to."""

import math
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.export.formats import MOST_DECIMALS
from pipeline.retime.result import TrajectorySamples

_ROUNDING_SHARE = 1e-4
"""Part of an acceleration limit that rounding may make when written positions are differenced twice."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Positions of the actuators at times, with velocities and accelerations where the format has them.

    Attributes
    ----------
    t_s : (n,)
        Time since the start.
    q_m, qd_mps, qdd_mps2 : (n, 5)
        c1, c2, c3, l2b, l3b, and derivatives; None where a format leaves them out.
    """

    t_s: FloatArray
    q_m: FloatArray
    qd_mps: FloatArray | None = None
    qdd_mps2: FloatArray | None = None


def motion_of(samples: TrajectorySamples) -> Motion:
    """Take the actuators' motion from samples of a trajectory."""
    return Motion(samples.t_s, samples.q_m, samples.qd_mps, samples.qdd_mps2)


def needed_decimals(period_s: float, acceleration_mps2: FloatArray, unit_m: float = 1.0) -> int:
    """Count the decimals at which positions differenced twice show accelerations, to 0.01 % of the smallest limit.

    Rounding by half of the last decimal makes up to 4 (10^-d / 2) / period^2 of it. More than all that a number has
    are never asked for.

    Parameters
    ----------
    unit_m : float
        Unit of length in which positions are written: 0.001 for millimetres.
    """
    allowed = _ROUNDING_SHARE * float(np.min(acceleration_mps2)) / unit_m
    return min(MOST_DECIMALS, max(0, math.ceil(-math.log10(allowed * period_s**2 / 2.0) - 1e-9)))
