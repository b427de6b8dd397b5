"""How far what a controller drives between the rows of an export is off the motion."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.export.controllers.cam import hermite
from pipeline.retime.result import Trajectory, TrajectorySamples

_BETWEEN = 8
"""Instants at which each period is compared."""
_MARGIN = 1.1
"""Between these instants there may be a little more."""


def quintic_deviation(trajectory: Trajectory, samples: TrajectorySamples) -> FloatArray:
    """Compute how far polynomials of degree five between rows are off the motion sampled there. Shape (5,), metres.

    The largest of several instants of every period, and a tenth more.
    """
    t = (samples.t_s[:-1, None] + samples.period_s * np.arange(1, _BETWEEN) / _BETWEEN).ravel()
    exact, off = trajectory.q(t), np.zeros(samples.q_m.shape[1])
    for k in range(len(off)):
        points = np.stack([values[:, k] for values in (samples.q_m, samples.qd_mps, samples.qdd_mps2)], axis=1)
        off[k] = np.abs(hermite(samples.t_s, points, t)[:, 0] - exact[:, k]).max()
    return _MARGIN * off
