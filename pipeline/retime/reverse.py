"""The way back: the same curve and the same motion, run backwards in time."""

from dataclasses import replace
from math import comb

import numpy as np
from scipy.interpolate import BSpline, PPoly

from pipeline.refine.result import Path
from pipeline.retime.result import Trajectory


def reversed_path(path: Path) -> Path:
    """The same curve from its end to its beginning: q(1 - s)."""
    knots, coefficients, degree = path.spline.tck
    spline = BSpline(1.0 - knots[::-1], coefficients[::-1], degree)
    return replace(path, spline=spline, node_s=1.0 - path.node_s[::-1], node_pose=path.node_pose[::-1])


def time_reversed(trajectory: Trajectory) -> Trajectory:
    """Drive a trajectory backwards: s_back(t) = 1 - s(T - t), the dwell at both ends changing places.

    A piece p(e), 0 <= e <= h, becomes 1 - p(h - e): its coefficient of e^k is -(-1)^k p^(k)(h) / k!. Velocities change
    their sign, accelerations stay, and so do forces, but for those of friction.
    """
    law = trajectory.time_law
    degree, h = len(law.c) - 1, np.diff(law.x)
    rows = []
    for k in range(degree, -1, -1):
        powers = range(k, degree + 1)
        at_end = sum(comb(p, k) * law.c[degree - p] * h ** (p - k) for p in powers)
        rows.append(-((-1.0) ** k) * at_end[::-1])
    rows[-1] = 1.0 + rows[-1]
    t = law.x[-1] - law.x[::-1]
    t[-1] = law.x[-1]
    return replace(
        trajectory,
        path=reversed_path(trajectory.path),
        time_law=PPoly(np.stack(rows), t),
        dwell_s=trajectory.dwell_s[::-1],
    )
