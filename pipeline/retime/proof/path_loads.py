"""Loads along a path, proven: forces of drives and links and the motion of the TCP, per path speed and acceleration.

The derivatives x1, x2 of the pose by s, and the links' forces per length g, are solutions of linear systems

    J x1 = -V q',    J x2 = -V q'' - terms of second order in x1 and q',    J' g = E' w,

with J = f' and V the derivatives of the closures by pose and actuators, and w the wrench of Newton and Euler (see
`pipeline.machine.dynamics`) about the axes E of the pose's coordinates. The solution y of A(t) y = b(t) is enclosed by
polynomials Y(t) through floats: with C(t) an approximate inverse of A(t),

    |y - Y| <= |C (b - A Y)| + |I - C A| |y - Y|.

Coefficients are balls that hold for every pose within the image of a box, the last ones over all of its interval.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat, arb_poly, arb_series

from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.inclusion.closure import TERMS, Closure, Geometry, Vector, closure, geometry, pose_series, shifted
from pipeline.inclusion.krawczyk import linear_inverse, residual_of_inverse
from pipeline.inclusion.matrices import ball_matrix, inner, magnitudes, matrices, times
from pipeline.inclusion.pieces import middle
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES
from pipeline.refine.motion import pose_derivatives
from pipeline.refine.result import Path
from pipeline.retime.path_dynamics import evaluate_dynamics
from pipeline.retime.proof.newton_euler import Weights, bending, turning, weights, wrenches
from pipeline.retime.proof.pose_boxes import PoseBox, interpolated, nodes, pose_boxes

_NODES = 5
"""Nodes of polynomials through floats: of degree four, the order to which residuals are enclosed."""
_LINKS, _AT_REST = 6, 2
_ARMS = ARM_OF_LINK.tolist()
_STROKES = {link: 3 + k for k, link in enumerate(TELESCOPES.tolist())}
"""The actuator of every telescope."""
Frames = tuple[Vector, Vector]
"""Series about the middle of an interval, and series that hold about every s in it."""


@dataclass(frozen=True, eq=False)
class BoxLoads:
    """Loads over a box, as polynomials in s less the middle of the box.

    Attributes
    ----------
    box : PoseBox
        The box.
    forces : (11, 3) of polynomials
        Of drives and links: factors of sdd and of sd^2, and what is left at rest; empty without masses.
    tcp : (3, 2) of polynomials
        First two derivatives of the TCP's position by s.
    """

    box: PoseBox
    forces: list[list[arb_poly]]
    tcp: list[list[arb_poly]]


@dataclass(frozen=True, eq=False)
class _Along:
    """The closures about one s, and the actuators' first two derivatives by s."""

    closure: Closure[arb_series]
    q1: Vector
    q2: Vector
    at: arb

    def series(self, coefficients: FloatArray) -> Vector:
        """Expand polynomials in s less the middle of the box, coefficients (n, k)."""
        return [shifted([arb(value) for value in column], self.at) for column in coefficients.T.tolist()]

    def by_actuators(self, derivative: Vector) -> Vector:
        """Compute -V q' for a derivative of the actuators."""
        along, lengths = self.closure.along_rails(), self.closure.lengths
        right = [along[link] * derivative[arm] for link, arm in enumerate(_ARMS)]
        for link, actuator in _STROKES.items():
            right[link] = right[link] + lengths[link] * derivative[actuator]
        return right


@dataclass(frozen=True, eq=False)
class _Inverse:
    """An approximate inverse C: bounds of |C| and |I - C A|, each 6 x 6."""

    size: list[list[arb]]
    miss: list[list[arb]]

    def errors(self, residual: list[arb_poly], half: arb) -> list[arb] | None:
        """Bound |y - Y| by the residual b - A Y of the polynomials Y; None if A may be singular."""
        norm = max((sum(row, arb(0)).abs_upper() for row in self.miss), key=float)
        if not norm < 1:
            return None
        first = times(self.size, [_magnitude(part, half) for part in residual])
        largest = max(first, key=float) / (1 - norm)
        return [(one + inner(row, [largest] * _LINKS)).abs_upper() for one, row in zip(first, self.miss, strict=True)]


def path_loads(path: Path) -> list[BoxLoads]:
    """Bound the loads along a path, box by box.

    Raises
    ------
    NoSolutionError
        Where a pose is not proven to be the only one near it, or the machine may be singular.
    """
    balls, boxes = geometry(path.machine), pose_boxes(path)
    known = _floats(path, np.concatenate([nodes(box.interval, _NODES) for box in boxes]))
    return [_loads(balls, path, box, rows) for box, rows in zip(boxes, np.split(known, len(boxes)), strict=True)]


def _floats(path: Path, s: FloatArray) -> FloatArray:
    """Compute x1, x2 and the forces per length of the links at s (n,): factors of sdd, sd^2, at rest. (n, 12 or 30)."""
    _, first, second, _ = pose_derivatives(path, s)
    if path.machine.masses is None:
        return np.concatenate([first, second], axis=1)
    dynamics = evaluate_dynamics(path, s)
    lengths = np.tile(np.nan_to_num(path.machine.lengths_m), (len(s), 1))
    lengths[:, TELESCOPES] = path.q(s)[:, 3:]
    return np.concatenate([first, second, *(part[:, 5:] / lengths for part in (dynamics.a, dynamics.b, dynamics.c))], 1)


def _loads(balls: Geometry, path: Path, box: PoseBox, known: FloatArray) -> BoxLoads:
    """Bound the loads over a box, from values in floats at its nodes (5, 12 or 30)."""
    _, width = middle(*box.interval)
    half, along = arb(width), [_expand(balls, box, at) for at in (arb(0), arb(0, width))]
    J = matrices(along[0].closure.jacobian(), along[1].closure.jacobian(), 3)
    C = [ball_matrix(part) for part in _inverse(box, J)]
    straight, turned = (_approximate(*parts, half) for parts in ((C, J), (_transposed(C), _transposed(J))))
    candidates = interpolated(box.interval, known)

    def enclosed(columns: slice, system: _Inverse, right: list[Vector], *, transposed: bool = False) -> list[Vector]:
        """Enclose a solution by the polynomials of some columns, about both frames."""
        series = [one.series(candidates[:, columns]) for one in along]
        missing = [
            [b - _product(row, y) for row, b in zip(_rows(one.closure, transposed), sides, strict=True)]
            for one, y, sides in zip(along, series, right, strict=True)
        ]
        errors = system.errors(_polynomials(*missing), half)
        if errors is None:
            raise _singular(box)
        return [[y + arb(0, e.upper()) for y, e in zip(part, errors, strict=True)] for part in series]

    x1 = enclosed(slice(0, 6), straight, [one.by_actuators(one.q1) for one in along])
    turns = [turning(one.closure, rate) for one, rate in zip(along, x1, strict=True)]
    bent = [
        bending(one.closure, rate, one.q1, turn, one.by_actuators(one.q2))
        for one, rate, turn in zip(along, x1, turns, strict=True)
    ]
    x2 = enclosed(slice(6, 12), straight, bent)
    tcp = [_polynomials(*(part[:3] for part in derivative)) for derivative in (x1, x2)]
    loads = [list(pair) for pair in zip(*tcp, strict=True)]
    if path.machine.masses is None:
        return BoxLoads(box, [], loads)
    body = weights(path.machine, balls)
    needed = [
        wrenches(one.closure, body, rate, bend, turn)
        for one, rate, bend, turn in zip(along, x1, x2, turns, strict=True)
    ]
    forces = []
    for k in range(3):
        columns, right = slice(12 + 6 * k, 18 + 6 * k), [wrench[k] for wrench in needed]
        g = enclosed(columns, turned, right, transposed=True)
        forces.append(_polynomials(*(_forces(one, body, part, k) for one, part in zip(along, g, strict=True))))
    return BoxLoads(box, [list(row) for row in zip(*forces, strict=True)], loads)


def _expand(balls: Geometry, box: PoseBox, at: arb) -> _Along:
    """Expand everything about the middle of a box, or about every s in it; poses are anywhere within its image."""
    pose = pose_series(box.inclusion.box.pose, at)
    pose = [x + arb(0, k.upper()) for x, k in zip(pose, box.inclusion.image, strict=True)]
    coefficients = [[arb(value) for value in row] for row in box.piece.taylor(box.centre)]
    q, q1, q2 = ([shifted(_derivative(row, order), at) for row in coefficients] for order in range(3))
    return _Along(closure(balls, pose, q), q1, q2, at)


def _derivative(coefficients: list[arb], order: int) -> list[arb]:
    polynomial = arb_poly(coefficients)
    for _ in range(order):
        polynomial = polynomial.derivative()
    return polynomial.coeffs() or [arb(0)]


def _inverse(box: PoseBox, J: list[arb_mat]) -> FloatArray:
    inverse = linear_inverse(J)
    if inverse is None:
        raise _singular(box)
    return inverse


def _approximate(C: list[arb_mat], A: list[arb_mat], half: arb) -> _Inverse:
    return _Inverse(magnitudes(C[0] + C[1] * arb(0, half.upper())), residual_of_inverse(C, A, half))


def _transposed(parts: list[arb_mat]) -> list[arb_mat]:
    return [part.transpose() for part in parts]


def _rows(motion: Closure[arb_series], transposed: bool) -> list[Vector]:
    rows = motion.jacobian()
    return [list(column) for column in zip(*rows, strict=True)] if transposed else rows


def _product(row: Vector, vector: Vector) -> arb_series:
    total = row[0] * vector[0]
    for a, b in zip(row[1:], vector[1:], strict=True):
        total = total + a * b
    return total


def _polynomials(at: Vector, over: Vector) -> list[arb_poly]:
    """Make polynomials whose last coefficient holds over all of the interval."""
    return [arb_poly([*(a[n] for n in range(TERMS - 1)), b[TERMS - 1]]) for a, b in zip(at, over, strict=True)]


def _magnitude(polynomial: arb_poly, half: arb) -> arb:
    return sum((value.abs_upper() * half**n for n, value in enumerate(polynomial.coeffs())), arb(0))


def _forces(along: _Along, body: Weights, g: Vector, part: int) -> Vector:
    """Compute the forces of drives and links from those per length: factors of sdd (0) and sd^2 (1), or at rest (2)."""
    links = [one * length for one, length in zip(g, along.closure.lengths, strict=True)]
    drives = [arb_series([arb(0)], prec=TERMS)] * 3
    for link, (arm, on_rail) in enumerate(zip(_ARMS, along.closure.along_rails(), strict=True)):
        drives[arm] = drives[arm] + g[link] * on_rail
    if part == _AT_REST:
        drives = [force + weight for force, weight in zip(drives, body.at_rest, strict=True)]
    else:
        moved = (along.q1, along.q2)[part]
        drives = [force + mass * moved[arm] for arm, (force, mass) in enumerate(zip(drives, body.carts, strict=True))]
    return [*drives, *(links[link] for link in _STROKES), *links]


def _singular(box: PoseBox) -> NoSolutionError:
    return NoSolutionError(
        "retime",
        f"forces in motion cannot be bounded: the machine may be singular at s = {box.centre:.4f}",
        "Keep the path farther from singularities: lower refine.kappa_max.",
        {"limit": "force", "s": box.centre},
    )
