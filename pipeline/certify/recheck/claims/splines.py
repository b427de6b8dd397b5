"""The splines of a path: boxes say nothing about what is not a continuous function on [0, 1]."""

import numpy as np
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.machine.geometry import ACTUATORS

SPLINES = "the splines are continuous from s = 0 to 1"


def spline_claim(spline: BSpline) -> Claim:
    """Verify that splines of shape (n, 5) are continuous functions on exactly [0, 1]."""
    fault = _fault(spline)
    inner = len(_knots_within(spline))
    return Claim(SPLINES, not fault, fault or f"degree {spline.k}, {inner + 1} pieces")


def _fault(spline: BSpline) -> str:
    """State what is wrong with splines; empty if nothing is.

    At a knot of multiplicity m > k the values before and after are coefficients, exactly; at others there is no jump.
    """
    t, c, k = spline.t, np.asarray(spline.c), int(spline.k)
    if c.dtype != np.float64 or c.ndim != 2 or c.shape[1] != len(ACTUATORS) or not np.isfinite(c).all():
        return f"expected {len(ACTUATORS)} columns of finite real coefficients"
    if (t[k], t[len(t) - k - 1]) != (0.0, 1.0):
        return f"they reach from {t[k]:g} to {t[len(t) - k - 1]:g}"
    within, counts = np.unique(t[(t > 0.0) & (t < 1.0)], return_counts=True)
    for knot in within[counts > k]:
        before, after = (int(np.searchsorted(t, knot, side=side)) for side in ("left", "right"))
        if not np.array_equal(c[before - 1], c[after - 1 - k]):
            return f"the actuators jump at s = {knot:g}"
    return ""


def _knots_within(spline: BSpline) -> FloatArray:
    return np.unique(spline.t[(spline.t > 0.0) & (spline.t < 1.0)])
