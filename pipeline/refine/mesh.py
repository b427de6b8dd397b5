"""Nodes and knots along s: even at first, finer where the path is difficult or breaks a requirement."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.refine.measure import kappa_trapezoids, sample_path
from pipeline.refine.result import Path
from pipeline.refine.splines import DEGREE, clamped_knots
from pipeline.route.metric import arc_length

_MARKED = 0.5
"""Share of the estimated error whose knot spans are halved: the fewest spans that hold it."""
_AS_LARGE = 1e-6
"""Relative difference within which errors count as equal: neighbours share a jump, and are marked together."""
_TOO_NEAR = 0.25
"""Share of the spacing: nodes nearer to each other make programs that solvers cannot scale."""
_SAMPLES_PER_INTERVAL = 8
_NODES, _SPANS = 8, 4
"""Intervals between nodes, and knot spans, of a straight end at least."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Collocation nodes s (k,), increasing from 0 to 1, and clamped knots (n + 6,) of n coefficients."""

    s: FloatArray
    knots: FloatArray

    @property
    def coefficients(self) -> int:
        """Spline coefficients per actuator."""
        return len(self.knots) - DEGREE - 1


def even_mesh(nodes: int, coefficients: int, also: FloatArray) -> Mesh:
    """Spread nodes and knots evenly; further nodes `also` (m,) replace inner ones that are too near."""
    s = np.linspace(0.0, 1.0, nodes)
    near = np.any(np.abs(s[1:-1, None] - also) < _TOO_NEAR / (nodes - 1), axis=1)
    return Mesh(np.union1d(np.concatenate([[0.0], s[1:-1][~near], [1.0]]), also), clamped_knots(coefficients))


def with_straight_ends(mesh: Mesh, s: FloatArray) -> Mesh:
    """Refine a mesh where its ends are straight, up to s (m,), and as far beyond: lines and corners take many knots.

    An s below one half ends a straight start, another one begins a straight goal.
    """
    nodes, knots = mesh.s, np.unique(mesh.knots)
    for at in s.tolist():
        length = min(at, 1.0 - at)
        nodes, knots = (_denser(part, at, length, count) for part, count in ((nodes, _NODES), (knots, _SPANS)))
    return Mesh(nodes, np.concatenate([np.zeros(DEGREE), knots, np.ones(DEGREE)]))


def _denser(s: FloatArray, at: float, length: float, count: int) -> FloatArray:
    """Divide the interval of a length between an end and `at` into as many parts at least, and the next like it."""
    count = max(count, int(np.count_nonzero(np.abs(s - at) < length)) // 2)
    part = length / count
    even = np.linspace(at - length, at + length, 2 * count + 1)
    # The first or the last of them is an end of the path, but for rounding.
    even = even[(even > part / 2.0) & (even < 1.0 - part / 2.0)]
    kept = s[(np.abs(s - at) > length + part / 2.0) | (s == 0.0) | (s == 1.0)]
    return np.union1d(kept, even)


def adapted_mesh(mesh: Mesh, path: Path, steps: FloatArray) -> Mesh:
    """Halve the knot spans that hold most of the estimated error, and the intervals of nodes in them.

    The error of the splines is estimated span by span from the jumps of the fifth derivative (they stand for the sixth,
    with which the distance to the best curve grows), that of the nodes from the part of the integral of kappa that the
    trapezoidal rule between neighbouring nodes misses; `steps` (5,) are the largest moves of the metric.
    """
    edges = np.unique(mesh.knots)
    spans = np.searchsorted(edges, midpoints(mesh.s)) - 1
    missed = np.bincount(spans, _missed(mesh, path, steps), minlength=len(edges) - 1).astype(float)
    marked = largest_part(_roughness(path, edges)) | largest_part(missed)
    knots = np.sort(np.concatenate([mesh.knots, midpoints(edges)[marked]]))
    return Mesh(np.union1d(mesh.s, midpoints(mesh.s)[marked[spans]]), knots)


def with_nodes(mesh: Mesh, broken: FloatArray) -> Mesh:
    """Halve every interval of nodes that contains one of the parameters `broken` (m,)."""
    intervals = np.unique(np.searchsorted(mesh.s, broken))
    intervals = intervals[(intervals > 0) & (intervals < len(mesh.s))]
    return Mesh(np.union1d(mesh.s, midpoints(mesh.s)[intervals - 1]), mesh.knots)


def _roughness(path: Path, edges: FloatArray) -> FloatArray:
    """Estimate how far the splines are from the best curve on every span between knots (m + 1,). Shape (m,)."""
    h = np.diff(edges)
    fifth = path.q(midpoints(edges), DEGREE)
    jumps = np.linalg.norm(np.diff(fifth, axis=0), axis=1)
    beside = np.maximum(np.append(0.0, jumps), np.append(jumps, 0.0))
    return np.asarray(beside * h**DEGREE, dtype=float)


def _missed(mesh: Mesh, path: Path, steps: FloatArray) -> FloatArray:
    """Estimate what the trapezoidal rule misses of the integral of kappa between neighbouring nodes. (k - 1,)."""
    part = np.linspace(0.0, 1.0, _SAMPLES_PER_INTERVAL + 1)[:-1]
    s = np.append((mesh.s[:-1, None] + part * np.diff(mesh.s)[:, None]).ravel(), 1.0)
    samples = sample_path(path, s)
    length, at = arc_length(samples.pose, steps), slice(None, None, _SAMPLES_PER_INTERVAL)
    fine = kappa_trapezoids(samples.kappa, np.diff(length)).reshape(-1, _SAMPLES_PER_INTERVAL).sum(axis=1)
    rough = kappa_trapezoids(samples.kappa[at], np.diff(arc_length(samples.pose[at], steps)))
    return np.asarray(np.abs(fine - rough), dtype=float)


def largest_part(error: FloatArray) -> BoolArray:
    """Mark the fewest entries (m,) that together hold their share of the sum, and all that are as large.

    Thus the same path, traversed backwards, has the same mesh.
    """
    falling = np.sort(error)[::-1]
    sums = np.cumsum(falling)
    least = falling[int(np.searchsorted(sums, _MARKED * sums[-1]))]
    return np.asarray((error >= least * (1.0 - _AS_LARGE)) & (error > 0.0), dtype=bool)


def midpoints(s: FloatArray) -> FloatArray:
    """Compute the midpoints between neighbours of s (n,). Shape (n - 1,)."""
    return (s[1:] + s[:-1]) / 2.0
