"""Loads along a path over many boxes, verified: the statement is that of `pipeline.retime.proof.path_loads`.

Candidates of solutions are their own Taylor polynomials, Y_n = C (b_n - sum of A_k Y_(n-k)), not values at nodes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, bound, contract, exactly, total, within
from pipeline.certify.recheck.arithmetic.inclusion import (
    Boxes,
    Inclusions,
    build_boxes,
    include,
    linear_inverse,
    power,
    residual_of_inverse,
)
from pipeline.certify.recheck.arithmetic.jets import TERMS, expand, product
from pipeline.certify.recheck.arithmetic.loads.dynamics import (
    Series,
    bending,
    by_actuators,
    derivative,
    forces,
    rates,
    wrenches,
)
from pipeline.certify.recheck.arithmetic.motion import Motion, follow
from pipeline.inclusion.krawczyk import Box
from pipeline.inclusion.uncertainty import CERTAIN
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path

_PARTS = 4
"""Parts of a piece of the path at first."""
_MOST_HALVINGS = 10
_NODES = np.cos(np.pi * (np.arange(4) + 0.5) / 4)
_THIN, _RADIUS = 1e-6, 4e-6
"""Largest distance of a pose from the cubic of its box, in metres and radians, and how far the box reaches."""


@dataclass(frozen=True, eq=False)
class PathLoads:
    """Loads over n boxes, as polynomials in s less the centre of each: coefficients first.

    Attributes
    ----------
    first, centre : (n,)
        Where boxes begin, and their middles.
    q1 : (degree, 5, n)
        First derivatives of the actuators by s.
    forces : three of (orders, 11, n)
        Factors of sdd and sd^2, and what is left at rest; none without masses.
    tcp : two of (orders, 3, n)
        First two derivatives of the TCP's position by s.
    proven : bool
        Every box holds one pose, which continues the path's known pose at s = 0, and all are bounded.
    """

    first: FloatArray
    centre: FloatArray
    q1: Enclosure
    forces: tuple[Series, ...]
    tcp: tuple[Series, Series]
    proven: bool


@dataclass(frozen=True, eq=False)
class _Frame:
    """The closures about one t, with the poses of the image, and the actuators' derivatives by s."""

    motion: Motion
    jacobian: Enclosure
    q1: Series
    q2: Series


def path_loads(path: Path) -> PathLoads:
    """Bound the loads along a path.

    Raises
    ------
    numpy.linalg.LinAlgError, ValueError, OverflowError
        If numbers are too large to compute with, or a matrix is singular.
    """
    boxes, found = _boxes(path)
    machine, h = path.machine, boxes.half
    frames = [_frame(machine, boxes, found.image, where) for where in (exactly(np.zeros_like(h)), within(h))]
    solver = _Solver(frames, h, transposed=False)
    x1 = solver.solve([by_actuators(one.motion, one.q1) for one in frames])
    turns = [rates(one.motion, x, one.q1) for one, x in zip(frames, x1, strict=True)]
    x2 = solver.solve(
        [
            bending(one.motion, turn, one.q1, by_actuators(one.motion, one.q2))
            for one, turn in zip(frames, turns, strict=True)
        ]
    )
    tcp = (_joined([x[:, :3] for x in x1]), _joined([x[:, :3] for x in x2]))
    loads: list[Series] = []
    if machine.masses is not None:
        solver = _Solver(frames, h, transposed=True)
        needed = [
            wrenches(machine, one.motion, a, b, turn) for one, a, b, turn in zip(frames, x1, x2, turns, strict=True)
        ]
        for k in range(3):
            g = solver.solve([wrench[k] for wrench in needed])
            moved = [(one.q1, one.q2, None)[k] for one in frames]
            parts = zip(frames, g, moved, strict=True)
            loads.append(_joined([forces(machine, one.motion, each, q) for one, each, q in parts]))
    finite = all(np.isfinite(part.rad).all() for part in (*loads, *tcp))
    proven = bool(found.proven.all() and finite and _continue(path, boxes, found))
    return PathLoads(boxes.first, boxes.centre, derivative(boxes.q, 1), tuple(loads), tcp, proven)


def _boxes(path: Path) -> tuple[Boxes, Inclusions]:
    """Place boxes about cubics through poses, and halve those that are not proven or far from their poses."""
    knots = np.unique(path.spline.t.clip(0.0, 1.0))
    ends = np.concatenate([np.linspace(a, b, _PARTS, endpoint=False) for a, b in pairwise(knots)])
    ends = np.append(ends, 1.0)
    for _ in range(_MOST_HALVINGS):
        boxes = build_boxes(path.machine, path, _placed(path, ends))
        found = include(path.machine, boxes, CERTAIN)
        coarse = ~(found.proven & (found.image < _THIN).all(axis=0))
        if not coarse.any():
            break
        ends = np.sort(np.concatenate([ends, boxes.centre[coarse]]))
    return boxes, found


def _placed(path: Path, ends: FloatArray) -> tuple[Box, ...]:
    centre, half = (ends[:-1] + ends[1:]) / 2.0, np.diff(ends) / 2.0
    poses = path.pose(centre[:, None] + half[:, None] * _NODES)
    cubics = np.einsum("ij,njk->nik", np.linalg.inv(np.vander(_NODES, increasing=True)), poses)
    cubics /= half[:, None, None] ** np.arange(4)[:, None]
    radius = np.full(6, _RADIUS)
    return tuple(
        Box(a, b, cubic, radius) for a, b, cubic in zip(ends[:-1].tolist(), ends[1:].tolist(), cubics, strict=True)
    )


def _continue(path: Path, boxes: Boxes, found: Inclusions) -> bool:
    """Check that the pose at the end of each box is that at the beginning of the next, and the known one at s = 0."""
    pose = exactly(boxes.pose)
    begins, ends = (expand(pose, exactly(s) - exactly(boxes.centre))[0] for s in (boxes.first, boxes.last))
    apart = total((begins[:, 1:] - ends[:, :-1]).magnitude, found.image[:, :-1])
    known = (begins[:, 0] - exactly(path.pose(0.0))).magnitude
    meets = np.array_equal(boxes.first[1:], boxes.last[:-1]) and boxes.first[0] == 0.0 and boxes.last[-1] == 1.0
    return bool(meets and (apart < boxes.radius[:, 1:]).all() and (known < boxes.radius[:, 0]).all())


def _frame(machine: Machine, boxes: Boxes, image: FloatArray, where: Enclosure) -> _Frame:
    pose = expand(exactly(boxes.pose), where)
    pose.rad[0] = total(pose.rad[0], image)
    q, q1, q2 = (expand(derivative(boxes.q, order), where) for order in range(3))
    motion = follow(machine, pose, q)
    return _Frame(motion, motion.jacobian(), q1, q2)


class _Solver:
    """Encloses solutions of A y = b, where A is the closure Jacobian or its transpose."""

    def __init__(self, frames: Sequence[_Frame], half: FloatArray, *, transposed: bool) -> None:
        jacobians = [one.jacobian for one in frames]
        self._A = [Enclosure(J.mid.swapaxes(1, 2), J.rad.swapaxes(1, 2)) if transposed else J for J in jacobians]
        at, over = self._A
        inverse = linear_inverse([at[0], at[1]])
        C = [exactly(part) for part in inverse]
        self._C0, self._half = inverse[0], half
        self._size = (C[0] + C[1] * within(half)).magnitude
        self._miss = residual_of_inverse(C, [at[0], at[1], over[2]], half)

    def solve(self, right: Sequence[Series]) -> list[Series]:
        """Enclose y for right-hand sides (orders, 6, n) about the middle and about every t."""
        Y = self._taylor(right[0])
        about = [expand(exactly(Y), where) for where in (exactly(np.zeros_like(self._half)), within(self._half))]
        missing = _joined([b - product(_times, A, y) for A, b, y in zip(self._A, right, about, strict=True)])
        sizes = total(
            *(bound("in,n->in", part.magnitude, power(self._half, n), terms=1) for n, part in _orders(missing))
        )
        first = bound("ijn,jn->in", self._size, sizes, terms=6)
        norm = total(*self._miss.swapaxes(0, 1)).max(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            largest = total(np.where(norm < 1.0, first.max(axis=0) / (1.0 - norm) * (1.0 + 1e-12), np.inf))
        errors = total(first, bound("ijn,n->in", self._miss, largest, terms=6))
        for y in about:
            y.rad[0] = total(y.rad[0], errors)
        return about

    def _taylor(self, right: Series) -> FloatArray:
        """Solve for the Taylor coefficients in floats, (orders, 6, n)."""
        A, found = self._A[0].mid, list[FloatArray]()
        for n in range(TERMS):
            known = right.mid[n].copy()
            for k in range(1, n + 1):
                known -= np.einsum("ijn,jn->in", A[k], found[n - k])
            found.append(np.einsum("ijn,jn->in", self._C0, known))
        return np.stack(found)


def _times(A: Enclosure, y: Enclosure) -> Enclosure:
    return contract("ijn,jn->in", A, y, 6)


def _orders(series: Series) -> list[tuple[int, Enclosure]]:
    return [(n, series[n]) for n in range(len(series.mid))]


def _joined(frames: Sequence[Series]) -> Series:
    """Make polynomials whose last coefficient holds over all of the interval."""
    at, over = frames
    mid, rad = at.mid.copy(), at.rad.copy()
    mid[-1], rad[-1] = over.mid[-1], over.rad[-1]
    return Enclosure(mid, rad)
