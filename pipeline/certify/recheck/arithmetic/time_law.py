"""A motion q(s(t)) over many intervals of time, in plain floats: Taylor coefficients by t, composed from those by s.

About the middle of an interval, |u| <= d, and with c_n the coefficients of a position by u,

    |q^(k)(u)| <= k! |c_k| + (k + 1)! |c_(k+1)| d + (k + 2)! |c_(k+2)| d^2 / 2,

the last one over the whole interval (Taylor's theorem). Intervals with bounds that do not suffice are halved.
"""

from dataclasses import dataclass
from math import factorial

import numpy as np
from scipy.interpolate import BSpline, PPoly

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, exactly, stacked, times, total, within
from pipeline.certify.recheck.arithmetic.jets import expand
from pipeline.certify.recheck.arithmetic.splines import spline_taylor

_ORDERS = 3
_TERMS = _ORDERS + 3
_FACTORIALS = np.array([factorial(n) for n in range(1, _ORDERS + 1)], dtype=float)[:, None, None]
_MOST_HALVINGS = 24
PASSED_BY = 1e-9
"""How far s may pass the ends of the path by rounding."""
_MOST_BEYOND = 64
"""Intervals that do not suffice, per piece of the law, after which none is halved any more."""


@dataclass(frozen=True, eq=False)
class _Intervals:
    """Intervals of time: pieces of the law (n,), and which parts of them, begin (n,) and width (n,), dyadic."""

    piece: IntArray
    begins: FloatArray
    width: FloatArray

    def __getitem__(self, rows: IntArray) -> "_Intervals":
        return _Intervals(self.piece[rows], self.begins[rows], self.width[rows])

    def halves(self) -> "_Intervals":
        """Halve each."""
        half = self.width / 2.0
        begins = np.concatenate([self.begins, self.begins + half])
        return _Intervals(np.tile(self.piece, 2), begins, np.tile(half, 2))


def largest_rates(spline: BSpline, law: PPoly, enough: FloatArray) -> tuple[FloatArray, bool]:
    """Bound velocities, accelerations and jerks of a motion at every instant, (3, 5), and say whether s is in [0, 1].

    Intervals are halved until below `enough`, and on the path to within 1e-9. Where that cannot be reached, the bounds
    are those of the intervals at which that was seen.
    """
    pieces = np.arange(law.c.shape[1])
    waiting, largest = _Intervals(pieces, np.zeros(len(pieces)), np.ones(len(pieces))), np.zeros_like(enough)
    for halvings in range(_MOST_HALVINGS + 1):
        bounds, attained, on_path = _bounds(spline, law, waiting)
        # What is certainly above needs no sharper bound.
        enough = np.where(attained > enough, np.inf, enough)
        beyond = ~((bounds <= enough[..., None]).all(axis=(0, 1)) & on_path)
        largest = np.maximum(largest, bounds[..., ~beyond].max(axis=2, initial=0.0))
        waiting = waiting[np.flatnonzero(beyond)]
        too_many = len(waiting.piece) > _MOST_BEYOND * len(pieces)
        if not beyond.any() or too_many or halvings == _MOST_HALVINGS:
            break
        waiting = waiting.halves()
    unsettled = np.nan_to_num(bounds[..., beyond], nan=np.inf)
    return np.maximum(largest, unsettled.max(axis=2, initial=0.0)), bool(on_path.all())


def _bounds(spline: BSpline, law: PPoly, intervals: _Intervals) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Bound the rates of all actuators over intervals (n,), shape (3, 5, n).

    Returns
    -------
    bounds, attained, on_path : (3, 5, n), (3, 5), (n,)
        The second is what some middle attains; the third says where s is certainly on the path.
    """
    c = exactly(law.c[::-1, intervals.piece])
    length = exactly(law.x[intervals.piece + 1]) - exactly(law.x[intervals.piece])
    middle = length * exactly(intervals.begins + intervals.width / 2.0)
    half = times(length.magnitude, intervals.width / 2.0)
    # About the middle first: powers of the time since the beginning of a piece would be far wider.
    about = expand(c, middle, max(_TERMS, len(law.c)))
    over = expand(about, within(half), _TERMS)
    rows, first = _pieces_met(spline, over[0])
    at_middle, everywhere = (_composed(spline, first, series[:_TERMS, rows]) for series in (about, over))
    bounds = np.stack([_rate(order, at_middle, everywhere, half[rows]) for order in range(1, _ORDERS + 1)])
    begins = np.flatnonzero(np.diff(rows, prepend=-1))
    found = np.maximum.reduceat(bounds, begins, axis=2)
    rates = at_middle[1 : _ORDERS + 1]
    sure = (np.abs(rates.mid) - rates.rad) * (1.0 - 1e-12) * _FACTORIALS
    # Where an interval meets two pieces of the path, it is not known which holds its middle.
    alone = np.bincount(rows, minlength=len(half))[rows] == 1
    on_path = (over[0].lower >= -PASSED_BY) & (over[0].upper <= 1.0 + PASSED_BY)
    return found, np.where(alone, sure, 0.0).max(axis=2, initial=0.0), on_path


def _pieces_met(spline: BSpline, s: Enclosure) -> tuple[IntArray, FloatArray]:
    """Pair intervals with the pieces of the path that hold some of their s: rows, and where these pieces begin."""
    knots = np.unique(spline.t[(spline.t >= 0.0) & (spline.t < 1.0)])
    first, last = (np.clip(np.searchsorted(knots, end, side="right") - 1, 0, None) for end in (s.lower, s.upper))
    counts = last - first + 1
    rows = np.repeat(np.arange(len(first)), counts)
    later = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
    return rows, knots[first[rows] + later]


def _composed(spline: BSpline, first: FloatArray, s: Enclosure) -> Enclosure:
    """Compose positions with series of s (terms, n): their Taylor coefficients by time (terms, 5, n)."""
    centre = s.mid[0]
    q = spline_taylor(spline.t, spline.c, spline.k, first, centre)
    along = Enclosure(s.mid.copy(), s.rad.copy())
    moved = s[0] - exactly(centre)
    along.mid[0], along.rad[0] = moved.mid, moved.rad
    result = _constant(q[-1])
    for n in range(len(q.mid) - 2, -1, -1):
        result = _times(result, along) + _constant(q[n])
    return result


def _constant(values: Enclosure) -> Enclosure:
    mid, rad = (np.zeros((_TERMS, *values.mid.shape)) for _ in range(2))
    mid[0], rad[0] = values.mid, values.rad
    return Enclosure(mid, rad)


def _times(a: Enclosure, b: Enclosure) -> Enclosure:
    """Multiply series (terms, 5, n) and (terms, n)."""
    orders = []
    for n in range(_TERMS):
        result = a[0] * b[n]
        for k in range(1, n + 1):
            result = result + a[k] * b[n - k]
        orders.append(result)
    return stacked(orders)


def _rate(order: int, at: Enclosure, over: Enclosure, half: FloatArray) -> FloatArray:
    """Bound a derivative by time over each interval, (5, n)."""
    value, slope = (factorial(n) * at[n].magnitude for n in (order, order + 1))
    bend = factorial(order + 2) / 2.0 * over[order + 2].magnitude
    return total(total(value), times(total(slope), half), times(total(bend), half, half))
