"""Distances of convex hulls of points, for many pairs of hulls at a time.

The algorithm of Gilbert, Johnson and Keerthi (1988): the distance of two hulls is that of the origin from the hull of
all differences a - b. A simplex of up to four of them is led towards the origin; v is its point nearest to it. For any
v the plane across v through the lowest difference separates the hulls by v . (a - b) / |v| at least, so that every
iterate bounds the distance from both sides:

    v . (a - b) / |v| <= distance <= |v|.

Arrays are stored coordinate by coordinate, the pairs last.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray

_MOST_STEPS = 60
_TOLERANCE_M = 1e-12
"""Difference of both bounds at which a distance is found."""
_TOUCHING_M = 1e-12
"""Hulls closer than this count as touching: there is no direction between them."""
_FLAT = 1e-14
"""Squared sine below which three points count as collinear."""


@dataclass(frozen=True, eq=False)
class Separation:
    """Distances of n pairs of hulls.

    Attributes
    ----------
    distance_m : (n,)
        The distance; zero where the hulls touch or overlap, however deep. Where it is beyond what was asked for, a
        lower bound of it.
    normal : (3, n)
        Unit vectors from the second hull to the first along the shortest connection: n . (a - b) is at least the
        distance for all their points, and the distance changes by n . (da - db) as they move. Zero where they touch.
    """

    distance_m: FloatArray
    normal: FloatArray


def hull_separation(first: FloatArray, second: FloatArray, beyond_m: float = np.inf) -> Separation:
    """Find the distances of pairs of hulls of points (j, 3, n) and (k, 3, n).

    Pairs that are certainly farther apart than `beyond_m` are not pursued: a bound that shows it will do.
    """
    n = first.shape[2]
    distance, normal = np.zeros(n), np.zeros((3, n))
    rows = np.arange(n)
    start = first.mean(axis=0) - second.mean(axis=0)
    v = _support(first, second, start)
    simplex, used = np.zeros((3, 3, n)), np.zeros((3, n), dtype=bool)
    simplex[0], used[0] = v, True
    for _ in range(_MOST_STEPS):
        size = np.sqrt(_dot(v, v))
        apart = size > _TOUCHING_M
        w = _support(first, second, v)
        low = _dot(v, w) / np.where(apart, size, 1.0)
        found = ~apart | (size - low <= _TOLERANCE_M) | (low > beyond_m)
        nearer, nearest = _nearest(simplex, used, w)
        # Differences of rounding errors lead nowhere.
        found |= _dot(nearer, nearer) >= size**2
        done = rows[found]
        distance[done] = np.where(apart, np.where(low > beyond_m, low, size), 0.0)[found]
        normal[:, done] = np.where(apart, v / np.where(apart, size, 1.0), 0.0)[:, found]
        going = ~found
        if not going.any():
            break
        rows, first, second = rows[going], first[..., going], second[..., going]
        v = nearer[:, going]
        simplex, used = _kept(simplex[..., going], w[:, going], nearest[:, going])
    return Separation(distance, normal)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2], dtype=float)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _support(first: FloatArray, second: FloatArray, v: FloatArray) -> FloatArray:
    """Find the difference a - b that is lowest along v. Shape (3, n)."""
    return _extreme(first, v, lowest=True) - _extreme(second, v, lowest=False)


def _extreme(points: FloatArray, v: FloatArray, *, lowest: bool) -> FloatArray:
    if len(points) == 1:
        return np.asarray(points[0])
    heights = points[:, 0] * v[0] + points[:, 1] * v[1] + points[:, 2] * v[2]
    at: IntArray = heights.argmin(axis=0) if lowest else heights.argmax(axis=0)
    return np.asarray(np.take_along_axis(points, at[None, None], axis=0)[0], dtype=float)


def _nearest(simplex: FloatArray, used: BoolArray, w: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Find the point nearest to the origin of the simplex of w and the points in use, (3, n), and what it is made of.

    It lies on a face that w is a corner of, since w is lower than all others: the faces are tried one after the other.
    Returns the corners beside w, (3, n); all three if the origin is inside.
    """
    d = simplex - w
    best, square = w.copy(), _dot(w, w)
    corners = np.zeros_like(used)
    for faces in ((_edge, ((0,), (1,), (2,))), (_triangle, ((0, 1), (0, 2), (1, 2)))):
        candidate, choices = faces
        for choice in choices:
            rows = np.flatnonzero(used[list(choice)].all(axis=0))
            if len(rows) == 0:
                continue
            point, good = candidate(w[:, rows], *(d[k][:, rows] for k in choice))
            value = _dot(point, point)
            good &= value < square[rows]
            rows, point, value = rows[good], point[:, good], value[good]
            best[:, rows], square[rows] = point, value
            corners[:, rows] = False
            for k in choice:
                corners[k, rows] = True
    rows = np.flatnonzero(used.all(axis=0))
    if len(rows):
        inside = rows[_holds_origin(w[:, rows], *(d[k][:, rows] for k in range(3)))]
        best[:, inside] = 0.0
        corners[:, inside] = True
    return best, corners


def _edge(w: FloatArray, d: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Project the origin onto lines w + t d, and tell for which of them 0 < t <= 1."""
    square = _dot(d, d)
    t = -_dot(d, w) / np.where(square > 0.0, square, 1.0)
    return w + t * d, (t > 0.0) & (t <= 1.0)


def _triangle(w: FloatArray, d: FloatArray, e: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Project the origin onto planes w + s d + t e, and tell which projections are inside the triangle."""
    m = _cross(d, e)
    square = _dot(m, m)
    flat = square <= _FLAT * _dot(d, d) * _dot(e, e)
    square = np.where(flat, 1.0, square)
    s, t = _dot(_cross(e, w), m) / square, _dot(_cross(w, d), m) / square
    return m * (_dot(w, m) / square), ~flat & (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0)


def _holds_origin(w: FloatArray, d: FloatArray, e: FloatArray, f: FloatArray) -> BoolArray:
    """Tell which tetrahedra w, w + d, w + e, w + f hold the origin. Shape (n,)."""
    volume = _dot(d, _cross(e, f))
    parts = [-_dot(w, _cross(e, f)), -_dot(w, _cross(f, d)), -_dot(w, _cross(d, e))]
    side = np.sign(volume)
    inside = (volume != 0.0) & (side * (parts[0] + parts[1] + parts[2]) <= np.abs(volume))
    for part in parts:
        inside &= side * part >= 0.0
    return np.asarray(inside, dtype=bool)


def _kept(simplex: FloatArray, w: FloatArray, corners: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Keep w and the corners beside it, three points at most in all: with four the origin is inside, and found."""
    order = np.argsort(~corners, axis=0, kind="stable")
    kept = np.take_along_axis(simplex, order[:2, None], axis=0)
    used = np.take_along_axis(corners, order[:2], axis=0)
    return np.concatenate([w[None], kept]), np.concatenate([np.ones((1, used.shape[1]), dtype=bool), used])
