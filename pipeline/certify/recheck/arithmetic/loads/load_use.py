"""Loads of a motion over many intervals of time, in plain floats: a(s(t)) sdd + b(s(t)) sd^2 + c(s(t)).

About the middle of an interval, |u| <= d, f(u) is within f(0) + f'(0) u + f''(v) u^2 / 2 for some v of it (Taylor's
theorem). Intervals whose bounds do not suffice are halved.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PPoly

from pipeline.arrays import FloatArray, IntArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, exactly, root, stacked, times, total, within
from pipeline.certify.recheck.arithmetic.jets import expand
from pipeline.certify.recheck.arithmetic.loads.path_loads import PathLoads

_TERMS = 3
_DRIVES, _FORCES, _WIDTH = 5, 11, 13
_MOST_HALVINGS, _MOST_WAITING = 12, 100_000
_STANDSTILL, _STILL = 1e-6, 1e-9
"""Path speed (1/s), and metres per unit of s, that count as standing still: rounding turns no friction."""


@dataclass(frozen=True, eq=False)
class _Intervals:
    """Parts of pieces of the law: pieces (n,), and which parts of them, begin (n,) and width (n,), dyadic."""

    piece: IntArray
    begins: FloatArray
    width: FloatArray

    def halves(self, rows: IntArray) -> "_Intervals":
        """Halve some of them."""
        half, begins = self.width[rows] / 2.0, self.begins[rows]
        both = np.concatenate([begins, begins + half])
        return _Intervals(np.tile(self.piece[rows], 2), both, np.tile(half, 2))


def largest_loads(loads: PathLoads, law: PPoly, friction: FloatArray, enough: FloatArray) -> FloatArray:
    """Bound positive and negative values of all loads at every instant, (2, 13), halving until below `enough`.

    Five drives, six links, speed and acceleration of the TCP; `friction` (5,) in newtons.
    """
    pieces = np.arange(law.c.shape[1])
    waiting, largest = _Intervals(pieces, np.zeros(len(pieces)), np.ones(len(pieces))), _at_rest(loads)
    for halvings in range(_MOST_HALVINGS + 1):
        rows, bounds = _bounds(loads, law, friction, waiting)
        bounds = np.nan_to_num(bounds, nan=np.inf)
        beyond = np.unique(rows[(bounds > enough[..., None]).any(axis=(0, 1))])
        done = ~np.isin(rows, beyond)
        last = halvings == _MOST_HALVINGS or 2 * len(beyond) > _MOST_WAITING
        largest = np.maximum(largest, bounds[..., done | last].max(axis=2, initial=0.0))
        if not len(beyond) or last:
            break
        waiting = waiting.halves(beyond)
    return largest


def _bounds(loads: PathLoads, law: PPoly, friction: FloatArray, intervals: _Intervals) -> tuple[IntArray, FloatArray]:
    """Bound loads over intervals, a row for each box met: numbers of intervals (m,), and bounds (2, 13, m)."""
    c = exactly(law.c[::-1, intervals.piece])
    length = exactly(law.x[intervals.piece + 1]) - exactly(law.x[intervals.piece])
    half = times(length.magnitude, intervals.width / 2.0)
    middle = length * exactly(intervals.begins + intervals.width / 2.0)
    about = expand(c, middle, max(_TERMS + 2, len(law.c)))
    over = expand(about, within(half), _TERMS + 2)
    first, last = (
        np.clip(np.searchsorted(loads.first, end, side="right") - 1, 0, None) for end in (over[0].lower, over[0].upper)
    )
    rows = np.repeat(np.arange(len(first)), last - first + 1)
    box = (
        first[rows]
        + np.arange(len(rows))
        - np.repeat(np.cumsum(last - first + 1) - (last - first + 1), last - first + 1)
    )
    h = half[rows]
    frames = [_Time(loads, series[:, rows], box) for series in (about, over)]
    bounds = np.zeros((2, _WIDTH, len(rows)))
    if loads.forces:
        upper, lower = _range(frames, [one.forces() for one in frames], h)
        pull = _friction(loads, frames, friction, h)
        upper[:_DRIVES], lower[:_DRIVES] = upper[:_DRIVES] + pull[0], lower[:_DRIVES] + pull[1]
        bounds[:, :_FORCES] = _widened(upper), _widened(-lower)
    for k, vectors in enumerate(zip(*(one.tcp() for one in frames), strict=True), start=_FORCES):
        upper, lower = _range(frames, list(vectors), h)
        sizes = _widened(np.maximum(np.abs(upper), np.abs(lower)))
        bounds[0, k] = root(total(*(times(one, one) for one in sizes)))
    return rows, bounds


class _Time:
    """Series by time of s and its derivatives, about the middles of intervals or about every instant of them."""

    def __init__(self, loads: PathLoads, s: Enclosure, box: IntArray) -> None:
        self._loads, self._box = loads, box
        slopes = [exactly(float(n)) for n in range(1, _TERMS + 2)]
        speed = stacked([s[n] * slopes[n - 1] for n in range(1, _TERMS + 2)])
        self.sd = speed[:_TERMS]
        self.sdd = stacked([speed[n] * slopes[n - 1] for n in range(1, _TERMS + 1)])
        self.squared = _times(self.sd, self.sd)
        offset = s[0] - exactly(loads.centre[box])
        self._along = stacked([offset, s[1], s[2]])

    def compose(self, coefficients: Enclosure) -> Enclosure:
        """Compose polynomials of the boxes with s: (orders, k, n) to (terms, k, m)."""
        at = coefficients[:, :, self._box]
        a = expand(at, self._along[0], _TERMS)
        first, second = self._along[1], self._along[2]
        return stacked([a[0], a[1] * first, a[1] * second + a[2] * (first * first)])

    def forces(self) -> Enclosure:
        """Compute forces of drives and links, (terms, 11, m)."""
        a, b, c = (self.compose(part) for part in self._loads.forces)
        return _times(a, self.sdd) + _times(b, self.squared) + c

    def tcp(self) -> tuple[Enclosure, Enclosure]:
        """Compute velocity and acceleration of the TCP, (terms, 3, m)."""
        first, second = (self.compose(part) for part in self._loads.tcp)
        return _times(first, self.sd), _times(first, self.sdd) + _times(second, self.squared)


def _times(a: Enclosure, b: Enclosure) -> Enclosure:
    """Multiply series by time."""
    return stacked([a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[0] * b[2] + a[1] * b[1] + a[2] * b[0]])


def _range(frames: Sequence[_Time], series: Sequence[Enclosure], half: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bound series (terms, k, m) over the intervals from above and below."""
    at, over = series
    spread = total(times(at[1].magnitude, half), times(over[2].magnitude, half, half))
    return at[0].upper + spread, at[0].lower - spread


def _widened(values: FloatArray) -> FloatArray:
    """Round up sums of bounds of either sign."""
    return np.asarray(values + 1e-12 * np.abs(values) + 1e-12)


def _friction(loads: PathLoads, frames: Sequence[_Time], friction: FloatArray, half: FloatArray) -> FloatArray:
    """Bound dry friction of the drives from above and below, (2, 5, m)."""
    ranges = [_range(frames, [one.compose(loads.q1) for one in frames], half)]
    ranges.append(_range(frames, [one.sd for one in frames], half))
    (most, least), (fastest, slowest) = ranges
    ways = [_signs(least, most, _STILL), _signs(slowest, fastest, _STANDSTILL)[:, None]]
    still = (np.abs(most) < _STILL) & (np.abs(least) < _STILL)
    products = np.stack([a * b for a in ways[0] for b in ways[1]]) * np.where(still, 0.0, 1.0)
    F = friction[:, None]
    return np.stack([products.max(axis=0) * F, products.min(axis=0) * F])


def _signs(low: FloatArray, high: FloatArray, rounding: float) -> FloatArray:
    """Give the least and the largest sign of values between two bounds, first axis 2."""
    forward, backward = low > -rounding, (high < rounding) & ~(low > -rounding)
    return np.stack([np.where(forward, 1.0, -1.0), np.where(backward, -1.0, 1.0)])


def _at_rest(loads: PathLoads) -> FloatArray:
    """Bound the forces that hold the machine at both ends of the path, (2, 13)."""
    largest = np.zeros((2, _WIDTH))
    for box, s in ((0, 0.0), (-1, 1.0)):
        if loads.forces:
            held = expand(loads.forces[2][:, :, [box]], exactly(s) - exactly(loads.centre[[box]]), 1)[0]
            largest[:, :_FORCES] = np.maximum(largest[:, :_FORCES], [held.upper[:, 0], -held.lower[:, 0]])
    return largest
