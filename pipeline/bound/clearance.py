"""Boxes in which two links are surely too close: a pair of their points is, at every pose of the box."""

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.bound.forms import Form, joined, linear
from pipeline.machine.clearance import link_pairs
from pipeline.machine.geometry import Machine

_ROUNDED = 1e-9
"""Metres by which the distance is proven to be too small, more than all roundings here."""


def too_close(machine: Machine, arms: Form, v: Form) -> BoolArray:
    """Find boxes all of whose poses have two links closer than allowed, for arms and vectors (6, 3, n). Shape (n,).

    Along links i and j the points a_i - s v_i and a_j - t v_j are taken that are nearest at the centre; s and t follow
    the box's coordinates to first order, as long as they stay within [0, 1].
    """
    found = np.zeros(v.c.shape[-1], dtype=bool)
    for i, j in link_pairs(machine):
        apart = arms[i] - arms[j]
        s, t, distance = _nearest(apart.c, v.c[i], v.c[j])
        some = np.flatnonzero(~found & (distance < machine.link_link_m))
        if some.size:
            d = _difference(apart.boxes(some), v[i].boxes(some), v[j].boxes(some), s[some], t[some])
            found[some] = _longest(d) < machine.link_link_m - _ROUNDED
    return found


def _nearest(apart: FloatArray, a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Find s and t in [0, 1] that minimise |apart - s a + t b|, for a, b (3, n); and that distance."""
    aa, bb, ab = (a * a).sum(axis=0), (b * b).sum(axis=0), (a * b).sum(axis=0)
    aw, bw = (apart * a).sum(axis=0), (apart * b).sum(axis=0)
    det = aa * bb - ab**2
    s = np.clip(np.where(det > 1e-9, (aw * bb - ab * bw) / np.maximum(det, 1e-9), 0.5), 0.0, 1.0)
    t = np.clip((s * ab - bw) / bb, 0.0, 1.0)
    s = np.clip((aw + t * ab) / aa, 0.0, 1.0)
    t = np.clip((s * ab - bw) / bb, 0.0, 1.0)
    return s, t, np.sqrt(((apart - s * a + t * b) ** 2).sum(axis=0))


def _difference(apart: Form, a: Form, b: Form, s: FloatArray, t: FloatArray) -> Form:
    """Enclose apart - s a + t b (3, n), s and t with slopes that minimise it to first order, if they stay within."""
    aa, bb, ab = ((x * y).sum(axis=0) for x, y in ((a.c, a.c), (b.c, b.c), (a.c, b.c)))
    det = np.maximum(aa * bb - ab**2, 1e-9)
    moved = apart.g + t * b.g - s * a.g
    p, q = (a.c * moved).sum(axis=1), (b.c * moved).sum(axis=1)
    slope_s = (p * bb - ab * q) / det
    slope_t = (slope_s * ab - q) / bb
    for middle, slope in ((s, slope_s), (t, slope_t)):
        reach = np.abs(slope).sum(axis=0)
        fits = (middle - reach >= 1e-12) & (middle + reach <= 1.0 - 1e-12)
        slope *= fits
    S, T = (linear(middle, slope) for middle, slope in ((s, slope_s), (t, slope_t)))
    return joined([apart[k] - S * a[k] + T * b[k] for k in range(3)])


def _longest(d: Form) -> FloatArray:
    """Bound |d| from above, d (3, n)."""
    return np.asarray(np.sqrt(((np.abs(d.c) + d.radius) ** 2).sum(axis=0)) * (1.0 + 1e-12), dtype=float)
