"""Distances between bodies in the nonlinear program, kept by separating planes.

Two hulls are at least c apart exactly if a vector n with |n| <= 1 and a number t exist for which n . b <= t for every
point b of the one, and n . a >= t + c for every point a of the other. With n and t as unknowns the condition is exact
and smooth. Of what is endless along X no x counts: n has none there.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.limits.interface.rows import Nodes, ProgramPart, Row, Unknowns
from pipeline.machine.bodies.placement import Frames
from pipeline.machine.bodies.symbolic import hull_function
from pipeline.machine.shapes.gjk import hull_separation
from pipeline.machine.shapes.model import Bodies

_REACH_M = 0.02
"""Pairs farther than this above their distance get no row: their unknowns cost more than adding them when needed."""
_NO_DIRECTION = 0.5
"""A direction shorter than this is none: the hulls overlap."""


@dataclass(frozen=True, eq=False)
class _Planes:
    """The planes between a pair of hulls at m nodes: normals (3, m) and offsets (m,)."""

    pair: tuple[int, int]
    nodes: IntArray
    normal: FloatArray
    offset: FloatArray


def separation_part(name: str, bodies: Bodies, distances_m: FloatArray, nodes: Nodes) -> ProgramPart:
    """Write the rows of all pairs that come near at the guess, and their separating planes.

    Parameters
    ----------
    distances_m : (k, pairs)
        Distances at the guess. The first and the last node are left out: they are given, and may be nearer than the
        margin allows.
    """
    reach = min(nodes.reach_m, _REACH_M)
    inner = np.arange(1, len(distances_m) - 1)
    near = distances_m[inner] < bodies.clearance_m + reach
    found = [_planes(bodies, pair, inner[near[:, k]], nodes) for k, pair in enumerate(bodies.pairs) if near[:, k].any()]
    if not found:
        return ProgramPart(unknowns=(), rows=())
    count = sum(len(planes.nodes) for planes in found)
    normal, offset = ca.MX.sym("n", 3, count), ca.MX.sym("t", 1, count)
    rows, begin = [], 0
    for planes in found:
        part = slice(begin, begin + len(planes.nodes))
        begin = part.stop
        rows += _apart(bodies, planes, (normal[:, part], offset[:, part]), nodes)
    return ProgramPart(
        unknowns=(_normals(bodies, found, normal), _offsets(found, offset)),
        rows=(
            Row(name, ca.vertcat(*rows), 0.0, np.inf),
            Row(f"separating planes ({name})", ca.vec(ca.sum1(normal**2)), -np.inf, 1.0),
        ),
    )


def _planes(bodies: Bodies, pair: tuple[int, int], at: IntArray, nodes: Nodes) -> _Planes:
    """Find the planes that separate a pair best at the guess, as far from what is asked for on either side."""
    guess = nodes.guess.take(at)
    frames = Frames.of(guess.machine, guess.pose, guess.carts_m)
    first, second = (frames.points(bodies.hulls[k]) for k in pair)
    if bodies.is_endless(pair):
        first[:, 0] = second[:, 0] = 0.0
    normal = hull_separation(first, second).normal
    between = first.mean(axis=0) - second.mean(axis=0)
    between /= np.maximum(np.linalg.norm(between, axis=0), 1e-12)
    normal = np.where(np.linalg.norm(normal, axis=0) > _NO_DIRECTION, normal, between)
    above, below = (np.einsum("cn,kcn->kn", normal, hull) for hull in (first, second))
    apart = bodies.radii_m(pair) + bodies.clearance_m + nodes.clearance_margin_m
    offset = (above.min(axis=0) - apart + below.max(axis=0)) / 2.0
    return _Planes(pair, at, normal, offset)


def _apart(bodies: Bodies, planes: _Planes, unknown: tuple[ca.MX, ca.MX], nodes: Nodes) -> list[ca.MX]:
    """Write n . a - t - c and t - n . b for all points, to be >= 0."""
    normal, offset = unknown
    at = planes.nodes.tolist()
    pose, q = nodes.pose[:, at], nodes.q[:, at]
    apart = bodies.radii_m(planes.pair) + bodies.clearance_m + nodes.clearance_margin_m
    heights = []
    for number in planes.pair:
        hull = bodies.hulls[number]
        points = hull_function(nodes.guess.machine, hull).map(len(at))(pose, q)
        # Every node has three columns, of x, y and z.
        axes = [points[:, axis::3] for axis in range(3)]
        heights.append(sum((axes[k] * ca.repmat(normal[k, :], len(hull.points_m), 1) for k in range(3)), ca.MX(0)))
    above, below = heights
    repeated = [ca.repmat(offset, part.shape[0], 1) for part in heights]
    return [ca.vec(above - repeated[0]) - apart, ca.vec(repeated[1] - below)]


def _normals(bodies: Bodies, found: list[_Planes], symbol: ca.MX) -> Unknowns:
    guess = np.concatenate([planes.normal.T for planes in found])
    bound = np.full_like(guess, np.inf)
    endless = np.concatenate([np.full(len(one.nodes), bodies.is_endless(one.pair)) for one in found])
    bound[endless, 0] = 0.0
    return Unknowns(symbol, guess, -bound, bound)


def _offsets(found: list[_Planes], symbol: ca.MX) -> Unknowns:
    guess = np.concatenate([planes.offset for planes in found])[:, None]
    return Unknowns(symbol, guess, np.full_like(guess, -np.inf), np.full_like(guess, np.inf))
