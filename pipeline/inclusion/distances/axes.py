"""Rigorous lower bounds of the distances between axes over a whole box, by directions that separate them.

For any n(t), the distance of two segments is at least min n . (P - Q) / |n| over their four pairs of end points P, Q.
The direction is linear in t, from those between closest points at both ends of the box. Any direction gives a valid
bound; a good one gives a sharp bound.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat

from pipeline.arrays import FloatArray, IntArray
from pipeline.inclusion.closure import Geometry
from pipeline.inclusion.condition import below, norm
from pipeline.inclusion.krawczyk import Piecewise
from pipeline.inclusion.matrices import ball_matrix

_LINKS = 6
_PARALLEL = 1e-12


@dataclass(frozen=True, eq=False)
class AxisPairs:
    """Pairs of axes whose distances are bounded.

    Attributes
    ----------
    first, second : (pairs, 2)
        The two end points of each, as columns of a table of cart joints, platform joints and rails.
    from_rail : bool
        Whether the second of every pair is a rail, an endless line along X.
    rails_m : (3, 2)
        y and z of the rails.
    """

    first: IntArray
    second: IntArray
    from_rail: bool
    rails_m: FloatArray

    @classmethod
    def of(cls, pairs: list[tuple[int, int]], from_rail: bool, rails_m: FloatArray) -> "AxisPairs":
        """Look up the end points of pairs of links, or of links and rails."""
        second = [(2 * _LINKS + b,) * 2 if from_rail else (b, _LINKS + b) for _, b in pairs]
        return cls(np.array([(a, _LINKS + a) for a, _ in pairs]), np.array(second), from_rail, rails_m)


def distance_bounds(machine: Geometry, pairs: AxisPairs, series: Piecewise, deviation: list[arb]) -> FloatArray:
    """Bound the distances of all pairs from below for poses within `deviation` of x(t). Shape (pairs,)."""
    points = _end_points(pairs, series)
    half = float(series.half.mid())
    values = [np.array([float(entry.mid()) for entry in table.entries()]).reshape(3, -1) for table in points]
    before, after = (
        separating_directions(pairs, (values[0] + t * values[1] + t * t * values[2]).T) for t in (-half, half)
    )
    n = [(before + after) / 2.0, (after - before) / (2.0 * half) if half > 0.0 else 0.0 * before]
    N = [ball_matrix(part) for part in n]
    terms = [
        N[0] * points[0],
        N[0] * points[1] + N[1] * points[0],
        N[0] * points[2] + N[1] * points[1],
        N[1] * points[2],
    ]
    off = _joint_deviation(machine, deviation)
    return np.array([_pair_bound(pairs, pair, terms, N, series.half, off) for pair in range(len(pairs.first))])


def _pair_bound(pairs: AxisPairs, pair: int, terms: list[arb_mat], N: list[arb_mat], h: arb, off: list[arb]) -> float:
    least = None
    for p in pairs.first[pair].tolist():
        for q in pairs.second[pair].tolist():
            gap = [term[pair, p] - term[pair, q] for term in terms]
            bound = gap[0] - sum((g.abs_upper() * h**k for k, g in enumerate(gap[1:], start=1)), arb(0))
            bound = bound.lower()
            least = bound if least is None else least.min(bound)
    assert least is not None
    sizes = [norm([N[0][pair, i] + N[1][pair, i] * t for i in range(3)]) for t in (-h, h)]
    size = sizes[0].max(sizes[1])
    if not size > 0:
        return 0.0
    moved = sum(
        (off[p - _LINKS] for p in (*pairs.first[pair], *pairs.second[pair]) if _LINKS <= p < 2 * _LINKS), arb(0)
    )
    return max(0.0, below(least / size - moved))


def _end_points(pairs: AxisPairs, series: Piecewise) -> list[arb_mat]:
    """Return cart joints, platform joints and rails as columns (3, 15): orders 0, 1 and, over the interval, 2."""
    tables = []
    for order, closure in ((0, series.at), (1, series.at), (2, series.over)):
        platform = [[p + a for p, a in zip(closure.pose, arm, strict=False)] for arm in closure.arms]
        carts = [
            [a - v for a, v in zip(joint, vector, strict=True)]
            for joint, vector in zip(platform, closure.vectors, strict=True)
        ]
        columns = [[coordinate[order] for coordinate in joint] for joint in (*carts, *platform)]
        scale = arb(int(order == 0))
        columns += [[arb(0), arb(float(y)) * scale, arb(float(z)) * scale] for y, z in pairs.rails_m]
        tables.append(arb_mat(columns).transpose())
    return tables


def _joint_deviation(machine: Geometry, deviation: list[arb]) -> list[arb]:
    """Bound how far each platform joint is from its position at x(t)."""
    shift, turn = norm(deviation[:3]), sum((d.abs_upper() for d in deviation[3:]), arb(0))
    return [shift + norm(point) * turn for point in machine.points]


def separating_directions(pairs: AxisPairs, points: FloatArray) -> FloatArray:
    """Compute unit vectors (..., pairs, 3) between closest points of each pair, for end points (..., 15, 3).

    They point from the second axis to the first. The proof does not rely on them.
    """
    P, Q = points[..., pairs.first, :], points[..., pairs.second, :]
    if pairs.from_rail:
        P[..., 0], Q[..., 0] = 0.0, 0.0
    u, v, r = P[..., 1, :] - P[..., 0, :], Q[..., 1, :] - Q[..., 0, :], P[..., 0, :] - Q[..., 0, :]
    uu, vv, uv, ur, vr = ((a * b).sum(axis=-1) for a, b in ((u, u), (v, v), (u, v), (u, r), (v, r)))
    square = uu * vv - uv**2
    with np.errstate(invalid="ignore", divide="ignore"):
        a = np.clip(np.where(square > _PARALLEL * uu * vv, (uv * vr - vv * ur) / square, 0.0), 0.0, 1.0)
        b = np.clip(np.where(vv > 0.0, (uv * a + vr) / vv, 0.0), 0.0, 1.0)
        a = np.clip(np.where(uu > 0.0, (uv * b - ur) / uu, 0.0), 0.0, 1.0)
    between = r + a[..., None] * u - b[..., None] * v
    length = np.linalg.norm(between, axis=-1, keepdims=True)
    return np.asarray(np.divide(between, length, out=np.zeros_like(between), where=length > 0.0), dtype=float)
