"""Where along X everything that moves is too close to what is fixed: one interval for each pair.

Carts and platform slide along X as one. With f(x) for the distance of a moving hull, shifted by x, from a fixed one, f
is convex, since both hulls are: it is below the required distance in one open interval, or nowhere. Newton's method on
a convex function, begun outside of that interval, stays outside: every iterate is a bound of the interval, and f is
known with its slope, n_x of the shortest connection.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.machine.bodies.placement import Frames
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.gjk import hull_separation
from pipeline.machine.shapes.model import Bodies

_MOST_STEPS = 20
_ENOUGH_M = 1e-6
"""A bound nearer than this to the end of an interval will do."""
_FLAT = 1e-9
"""Slope below which the least distance is reached."""
_ROUNDING_M = 1e-9


def excluded_shifts(bodies: Bodies, samples: PoseSamples, windows_m: FloatArray) -> FloatArray:
    """Find by which shifts along X each pair would be too close, for n poses. Shape (n, pairs, 2), NaN where by none.

    Intervals are open: their ends are allowed. They are exact to a micrometre where they meet the windows of shifts
    (n, 2) that count, and may be wider elsewhere.
    """
    frames = Frames.of(samples.machine, samples.pose, samples.carts_m)
    found = np.full((len(samples), len(bodies.pairs), 2), np.nan)
    placed = {k: frames.points(bodies.hulls[k]) for k in {k for pair in bodies.pairs for k in pair}}
    boxes = {k: (points.min(axis=0), points.max(axis=0)) for k, points in placed.items()}
    # Hulls of the same numbers of points are pursued together.
    groups: dict[tuple[int, int], list[_Candidates]] = {}
    for k, (i, j) in enumerate(bodies.pairs):
        apart = bodies.radii_m((i, j)) + bodies.clearance_m
        beside, ends = _outer_bounds(boxes[i], boxes[j], apart)
        found[beside, k] = ends[beside]
        rows = np.flatnonzero(beside & (ends[:, 0] < windows_m[:, 1]) & (ends[:, 1] > windows_m[:, 0]))
        if len(rows):
            first, second = placed[i][..., rows], placed[j][..., rows]
            one = _Candidates(rows, k, first, second, apart, ends[rows])
            groups.setdefault((len(first), len(second)), []).append(one)
    for group in groups.values():
        ends = _newton(group)
        at = np.cumsum([len(one.rows) for one in group])[:-1]
        for one, inner in zip(group, np.split(ends, at), strict=True):
            found[one.rows, one.pair] = inner
    return found + [-_ROUNDING_M, _ROUNDING_M]


@dataclass(frozen=True, eq=False)
class _Candidates:
    """A pair at n of the poses, whose outer bounds meet the windows: hulls (k, 3, n), and these bounds (n, 2)."""

    rows: IntArray
    pair: int
    first: FloatArray
    second: FloatArray
    apart: float
    ends: FloatArray


def _outer_bounds(
    box: tuple[FloatArray, FloatArray], other: tuple[FloatArray, FloatArray], apart: float
) -> tuple[BoolArray, FloatArray]:
    """Bound intervals from outside, by boxes along the axes, least and largest corners (3, n) each.

    Returns whether the boxes are nearer than `apart` along Y and along Z, (n,), and beyond which shifts they are apart
    along X, (n, 2).
    """
    (low, high), (other_low, other_high) = box, other
    beside = (low - other_high < apart) & (other_low - high < apart)
    return beside[1] & beside[2], np.stack([other_low[0] - high[0] - apart, other_high[0] - low[0] + apart], axis=1)


def _newton(group: list[_Candidates]) -> FloatArray:
    """Move both ends of all intervals of a group inwards as far as they go; NaN where there is none. Shape (n, 2)."""
    first, second = (np.concatenate([getattr(one, name) for one in group], axis=2) for name in ("first", "second"))
    apart = np.concatenate([np.full(len(one.rows), one.apart) for one in group])
    ends = np.concatenate([one.ends for one in group])
    for side, sense in ((0, 1.0), (1, -1.0)):
        rows = np.flatnonzero(~np.isnan(ends[:, 0]))
        for _ in range(_MOST_STEPS):
            if len(rows) == 0:
                break
            moved = first[..., rows]
            moved[:, 0] += ends[rows, side]
            found = hull_separation(moved, second[..., rows])
            gap, slope = found.distance_m - apart[rows], sense * found.normal[0]
            nowhere = (slope >= -_FLAT) & (gap > 0.0)
            ends[rows[nowhere]] = np.nan
            step = np.where(nowhere, 0.0, np.maximum(gap, 0.0) / np.maximum(-slope, _FLAT))
            ends[rows, side] += sense * step
            rows = rows[step > _ENOUGH_M]
    ends[~(ends[:, 0] < ends[:, 1])] = np.nan
    return ends


def free_pieces(windows_m: FloatArray, excluded_m: FloatArray) -> tuple[IntArray, FloatArray]:
    """Give what open intervals (n, p, 2) leave of windows (n, 2): the row of each piece (m,), and the pieces (m, 2)."""
    n = len(windows_m)
    low = np.where(np.isnan(excluded_m[..., 0]), np.inf, excluded_m[..., 0])
    order = np.argsort(low, axis=1, kind="stable")
    low = np.take_along_axis(low, order, axis=1)
    high = np.take_along_axis(np.where(np.isnan(excluded_m[..., 1]), -np.inf, excluded_m[..., 1]), order, axis=1)
    # Between the largest end so far and the next beginning nothing is excluded.
    begins = np.concatenate([np.full((n, 1), -np.inf), np.maximum.accumulate(high, axis=1)], axis=1)
    ends = np.concatenate([low, np.full((n, 1), np.inf)], axis=1)
    first, last = np.maximum(begins, windows_m[:, :1]), np.minimum(ends, windows_m[:, 1:])
    # What has no interval of its own ends where the one before does: an empty piece, or the rest a second time.
    kept = first <= last
    kept[:, 1:] &= (ends[:, 1:] > ends[:, :-1]) | (begins[:, 1:] > begins[:, :-1])
    row, column = np.nonzero(kept)
    return row, np.column_stack([first[row, column], last[row, column]])


def longest_free(windows_m: FloatArray, excluded_m: FloatArray) -> FloatArray:
    """Give the longest piece that open intervals (n, p, 2) leave of windows (n, 2), NaN where none. Shape (n, 2)."""
    row, found = free_pieces(windows_m, excluded_m)
    order = np.lexsort((found[:, 0] - found[:, 1], row))
    row, first = np.unique(row[order], return_index=True)
    longest = np.full_like(windows_m, np.nan)
    longest[row] = found[order][first]
    return longest
