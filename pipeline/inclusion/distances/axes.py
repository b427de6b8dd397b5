"""Rigorous lower bounds of the distances between axes over a whole box, by directions that separate them.

For any n(t), the distance of two segments is at least min n . (P - Q) / |n| over their four pairs of end points P, Q.
The direction is linear in t, from those between closest points at both ends of the box. Any direction gives a valid
bound; a good one gives a sharp bound. A rail is an endless line, d along it: there n . d has to be zero exactly.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from flint import arb, arb_mat

from pipeline.arrays import FloatArray, IntArray
from pipeline.inclusion.condition import above, below, norm
from pipeline.inclusion.displacement import Displacement
from pipeline.inclusion.following import CARTS, Erring, joint_moves
from pipeline.inclusion.krawczyk import Piecewise
from pipeline.inclusion.matrices import ball_matrix, enlarged, floats, inner, upper_bounds, upper_vector
from pipeline.machine.geometry import ACTUATORS, Machine

_LINKS, _ERRORS = 6, len(ACTUATORS)
_PARALLEL = 1e-12
_PROBE, _FASTEST_PER_M = 1e-6, 1e3


@dataclass(frozen=True, eq=False)
class AxisPairs:
    """Pairs of axes whose distances are bounded.

    Attributes
    ----------
    first, second : (pairs, 2)
        The two end points of each, as columns of a table of cart joints, platform joints and rails.
    from_rail : bool
        Whether the second of every pair is a rail, an endless line.
    rails_m : (3, 2)
        y and z of the rails where x is 0.
    along : (pairs, 3)
        Directions of the rails that are second; of no use for links.
    """

    first: IntArray
    second: IntArray
    from_rail: bool
    rails_m: FloatArray
    along: FloatArray

    @classmethod
    def of(cls, pairs: list[tuple[int, int]], from_rail: bool, machine: Machine) -> "AxisPairs":
        """Look up the end points of pairs of links, or of links and rails."""
        along = machine.rail_directions[[b for _, b in pairs] if from_rail else [0] * len(pairs)]
        second = [(2 * _LINKS + b,) * 2 if from_rail else (b, _LINKS + b) for _, b in pairs]
        return cls(np.array([(a, _LINKS + a) for a, _ in pairs]), np.array(second), from_rail, machine.rails_m, along)


@dataclass(frozen=True, eq=False)
class _Gaps:
    """What distances along x(t) follow from.

    Attributes
    ----------
    N : 2 matrices pairs x 3
        Directions N0 + N1 t.
    least : pairs x 4 balls
        Lower bounds of n . (P - Q), for the four pairs of end points.
    sizes : pairs bounds
        |n|.
    turning : (5, pairs, 3)
        M_k: how fast directions turn with errors of the actuators, in the middle of the interval.
    points : 3 x 15 balls
        End points over the interval.
    """

    N: list[arb_mat]
    least: list[list[arb]]
    sizes: list[arb]
    turning: FloatArray
    points: arb_mat


def distance_bounds(
    pairs: AxisPairs, series: Piecewise, displacement: Displacement, errors: Erring | None = None
) -> FloatArray:
    """Bound the distances of all pairs from below for joints displaced from x(t), or from x(t) + P a for all a.

    Shape (pairs,).
    """
    gaps = series.derive((pairs.from_rail, pairs.first.tobytes()), lambda: _along(pairs, series))
    off, (least, sizes) = displacement.rest, (gaps.least, gaps.sizes)
    if displacement.moves:
        least = _with_moves(pairs, gaps, gaps.N[0] + gaps.N[1] * arb(0, series.half), displacement.moves)
    if errors is not None:
        least, sizes = _with_errors(pairs, gaps, gaps.N[0] + gaps.N[1] * arb(0, series.half), errors)
    return np.array([_pair_bound(pairs, pair, gap, off) for pair, gap in enumerate(zip(least, sizes, strict=True))])


def _ends(pairs: AxisPairs, pair: int) -> list[tuple[int, int]]:
    return list(product(pairs.first[pair].tolist(), pairs.second[pair].tolist()))


def _along(pairs: AxisPairs, series: Piecewise) -> _Gaps:
    points = _end_points(pairs, series)
    half = float(series.half.mid())
    values = [floats(table) for table in points]
    before, after = (
        separating_directions(pairs, (values[0] + t * values[1] + t * t * values[2]).T) for t in (-half, half)
    )
    n = [(before + after) / 2.0, (after - before) / (2.0 * half) if half > 0.0 else 0.0 * before]
    N = [_across(pairs, ball_matrix(part)) for part in n]
    terms = [
        N[0] * points[0],
        N[0] * points[1] + N[1] * points[0],
        N[0] * points[2] + N[1] * points[1],
        N[1] * points[2],
    ]
    h, least = series.half, []
    for pair in range(len(pairs.first)):
        gaps = [[term[pair, p] - term[pair, q] for term in terms] for p, q in _ends(pairs, pair)]
        least.append([(g[0] - sum((g[k].abs_upper() * h**k for k in range(1, 4)), arb(0))).lower() for g in gaps])
    ends = [(N[0] + N[1] * t).table() for t in (-h, h)]
    sizes = [norm(first).max(norm(last)) for first, last in zip(*ends, strict=True)]
    everywhere = points[0] + points[1] * arb(0, h) + points[2] * arb(0, h * h)
    return _Gaps(N, least, sizes, _turning(pairs, series, values[0].T), everywhere)


def _with_errors(pairs: AxisPairs, gaps: _Gaps, N: arb_mat, errors: Erring) -> tuple[list[list[arb]], list[arb]]:
    """Bound n . (P - Q) from below and |n| for all errors a, with n = N(t) + sum a_k M_k; N over the interval.

    M_k follows how directions between closest points turn. With S_k enclosing the derivatives of the end points,

        n . (P - Q) >= N . D - sum |N . S_k + M_k . D| A_k - (sum |M_k| A_k) (sum |S_k| A_k),   D = P - Q along x(t).
    """
    A, S = errors.following.errors, joint_moves(errors)
    M = [_across(pairs, ball_matrix(part)) for part in gaps.turning]
    by_error = [(N * part + turn * gaps.points) * a for part, turn, a in zip(S, M, A, strict=True)]
    size = upper_vector(A)
    lengths = np.array([[above(norm(row)) for row in part.table()] for part in M])
    turned = enlarged((lengths * size[:, None]).sum(axis=0))
    middles = np.array([floats(part) for part in S])
    radii = np.array([upper_bounds(part - ball_matrix(middle)) for part, middle in zip(S, middles, strict=True)])
    p, q = pairs.first[:, :, None], pairs.second[:, None, :]
    apart = np.abs(middles[..., p] - middles[..., q]) + radii[..., p] + radii[..., q]
    second = enlarged(turned[:, None, None] * np.einsum("kpij,k->pij", np.sqrt(np.square(apart).sum(axis=1)), size))
    normals, rows, least, sizes = N.table(), [rates.table() for rates in M], [], []
    for pair, bounds in enumerate(gaps.least):
        lost = zip(_ends(pairs, pair), second[pair].ravel().tolist(), strict=True)
        closer = [
            sum(((row[pair, p] - row[pair, q]).abs_upper() for row in by_error), arb(more)) for (p, q), more in lost
        ]
        least.append([bound - by for bound, by in zip(bounds, closer, strict=True)])
        along = inner([inner(normals[pair], rates[pair]).abs_upper() for rates in rows], A)
        sizes.append((gaps.sizes[pair] ** 2 + 2 * along + arb(float(turned[pair])) ** 2).sqrt().abs_upper())
    return least, sizes


def _across(pairs: AxisPairs, directions: arb_mat) -> arb_mat:
    """Make directions pairs x 3 normal to the rails exactly, by their x: n_x d_x = -(n_y d_y + n_z d_z)."""
    if not pairs.from_rail:
        return directions
    for pair, (x, y, z) in enumerate(pairs.along.tolist()):
        directions[pair, 0] = -(directions[pair, 1] * arb(y) + directions[pair, 2] * arb(z)) / arb(x)
    return directions


def _with_moves(pairs: AxisPairs, gaps: _Gaps, N: arb_mat, moves: list[arb_mat]) -> list[list[arb]]:
    """Bound n . (P - Q) from below where end points P move by M_P v, |v| <= 1: it changes by up to |n' (M_P - M_Q)|."""
    along, found = [N * move for move in moves], []
    for pair, bounds in enumerate(gaps.least):
        lost = [
            norm([a - b for a, b in zip(_row(along[p], pair), _row(along[q], pair), strict=True)])
            for p, q in _ends(pairs, pair)
        ]
        found.append([bound - by for bound, by in zip(bounds, lost, strict=True)])
    return found


def _row(matrix: arb_mat, row: int) -> list[arb]:
    return [matrix[row, column] for column in range(matrix.ncols())]


def _pair_bound(pairs: AxisPairs, pair: int, gap: tuple[list[arb], arb], off: list[arb]) -> float:
    """Bound the distance of a pair by the gaps of its end points, and |n|; end points (15,) are `off` by as much."""
    (bounds, size), least = gap, arb("inf")
    for bound in bounds:
        least = least.min(bound.lower())
    if not size > 0:
        return 0.0
    # No point between two ends moves farther than the end that moves farther.
    moved = [off[p].max(off[q]) for p, q in (pairs.first[pair].tolist(), pairs.second[pair].tolist())]
    return max(0.0, below(least / size - moved[0] - moved[1]))


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


def separating_directions(pairs: AxisPairs, points: FloatArray) -> FloatArray:
    """Compute unit vectors (..., pairs, 3) between closest points of each pair, for end points (..., 15, 3).

    They point from the second axis to the first. The proof does not rely on them.
    """
    P, Q = points[..., pairs.first, :], points[..., pairs.second, :]
    if pairs.from_rail:
        for points in (P, Q):
            points -= (points * pairs.along[:, None]).sum(axis=-1, keepdims=True) * pairs.along[:, None]
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


def _turning(pairs: AxisPairs, series: Piecewise, points: FloatArray) -> FloatArray:
    if series.symbols is None:
        return np.zeros((_ERRORS, len(pairs.first), 3))
    axes, arms = (
        np.array([[float(entry[0].mid()) for entry in vector] for vector in part])
        for part in (series.at.axes, series.at.arms)
    )
    rails = np.array([[float(entry.mid()) for entry in rail] for rail in series.at.rails])
    return turning_rates(pairs, points, joint_rates(axes, arms, series.symbols.matrix[0], rails))


def joint_rates(axes: FloatArray, arms: FloatArray, P: FloatArray, rails: FloatArray) -> FloatArray:
    """Estimate how end points move with errors, (5, ..., 15, 3); axes (..., 3, 3), arms (..., 6, 3), P (..., 6, 5).

    `rails` (6, 3) are the directions of the links' rails. No proof relies on it, nor on `turning_rates`.
    """
    moves = np.zeros((_ERRORS, *arms.shape[:-2], 15, 3))
    moves[np.array(CARTS), ..., np.arange(_LINKS), :] = np.reshape(rails, (_LINKS, *[1] * (arms.ndim - 2), 3))
    turned = np.cross(axes[..., None, :, :], arms[..., :, None, :])
    platform = P[..., None, :3, :] + np.einsum("...ljc,...jk->...lck", turned, P[..., 3:, :])
    moves[..., _LINKS : 2 * _LINKS, :] = np.moveaxis(platform, -1, 0)
    return moves


def turning_rates(pairs: AxisPairs, points: FloatArray, moves: FloatArray) -> FloatArray:
    """Estimate how fast directions turn, (5, ..., pairs, 3), as end points (..., 15, 3) move by (5, ..., 15, 3)."""
    before, after = (separating_directions(pairs, points + side * _PROBE * moves) for side in (-1.0, 1.0))
    rates = (after - before) / (2.0 * _PROBE)
    # Where closest points change from one end to another, directions jump.
    bounded = np.linalg.norm(rates, axis=-1, keepdims=True) < _FASTEST_PER_M
    return np.asarray(np.where(bounded, rates, 0.0), dtype=float)
