"""A nonlinear program over collocation nodes in CasADi: unknowns and rows that all have, and how it is put together.

Unknowns are pose (6) and actuators (5) of every node and the spline coefficients, then those of limits and of the
program itself. With the actuators as unknowns of their own the Hessian is sparse: a node touches itself and its
neighbour.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import casadi as ca
import numpy as np
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray
from pipeline.limits.interface.rows import Nodes, ProgramPart, Row, Unknowns
from pipeline.machine.pose import CONTROLLED
from pipeline.machine.samples import PoseSamples
from pipeline.refine.collocation.data import NodeData
from pipeline.refine.collocation.derivatives import derivative_options
from pipeline.refine.collocation.node_kappa import NodeKappa
from pipeline.refine.collocation.rows import node_rows, one_way_rows, side_rows, wall_rows
from pipeline.refine.one_way import one_way_legs
from pipeline.refine.result import directions_of
from pipeline.route.metric import arc_length

Written = Callable[[ca.MX, ca.MX], tuple[ca.MX, list[Row]]]
"""Writes the objective, and rows with kappa in them, of the kappa of the nodes and its integral."""


@dataclass(frozen=True, eq=False)
class Symbols:
    """Unknowns of every program: pose (6, k), q (5, k), coefficients (5, n)."""

    pose: ca.MX
    q: ca.MX
    coefficients: ca.MX

    @classmethod
    def of(cls, data: NodeData) -> "Symbols":
        """Make the symbols for a mesh."""
        k, n = len(data.mesh.s), data.mesh.coefficients
        return cls(ca.MX.sym("pose", 6, k), ca.MX.sym("q", 5, k), ca.MX.sym("c", 5, n))


@dataclass(frozen=True, eq=False)
class Block:
    """A named group of constraints: rows of g from `begin` to `end`, for messages that say what is violated."""

    name: str
    begin: int
    end: int


@dataclass(frozen=True, eq=False)
class Program:
    """A nonlinear program ready for a solver: CasADi expressions, bounds, guess, and how to read its solution.

    Attributes
    ----------
    problem : dict
        Unknowns x, objective f and constraints g.
    derivatives : dict
        Those of `derivatives.derivative_options`.
    integral : ca.Function
        x -> the integral of the smooth kappa.
    variable_bounds, constraint_bounds : pair of (n,), pair of (m,)
        Lower and upper bounds.
    guess : (n,)
        Where the solver starts.
    blocks : tuple of Block
        Names of the constraints.
    nodes, coefficients : int
        How many nodes there are, and spline coefficients per actuator.
    kappa : NodeKappa or None
        What computes kappa, which has to live as long as the program.
    """

    problem: dict[str, ca.MX]
    derivatives: dict[str, ca.Function]
    integral: ca.Function
    variable_bounds: tuple[FloatArray, FloatArray]
    constraint_bounds: tuple[FloatArray, FloatArray]
    guess: FloatArray
    blocks: tuple[Block, ...]
    nodes: int
    coefficients: int
    kappa: NodeKappa | None = None

    def poses(self, x: FloatArray) -> FloatArray:
        """Return the poses of the nodes in a solution vector, shape (nodes, 6)."""
        return x[: 6 * self.nodes].reshape(self.nodes, 6)

    def spline_coefficients(self, x: FloatArray) -> FloatArray:
        """Return the spline coefficients in a solution vector, shape (coefficients, 5)."""
        begin = 11 * self.nodes
        return x[begin : begin + 5 * self.coefficients].reshape(self.coefficients, 5)


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of neighbouring nodes in the metric of the route, (1, k - 1), and their squares before smoothing."""

    squared: ca.MX
    smooth: ca.MX


def distances(data: NodeData, guess: PoseSamples, x: Symbols, smoothing: float) -> Distances:
    """Write distances; a share `smoothing` of the guess's mean is added in quadrature: zero has no derivative."""
    axes = list(CONTROLLED)
    moves = (x.pose[axes, 1:] - x.pose[axes, :-1]) / ca.DM(data.steps)
    squared = ca.sum1(moves**2)
    mean = float(arc_length(guess.pose, data.steps)[-1]) / len(guess)
    return Distances(squared, ca.sqrt(squared + (smoothing * mean) ** 2))


def node_part(data: NodeData, guess: PoseSamples, spline: BSpline, x: Symbols) -> ProgramPart:
    """Write what nodes keep in every program, and the unknowns that limits bring; the guess is on the spline."""
    directions = directions_of(spline(data.mesh.s, nu=1))
    at_nodes = Nodes(x.pose, x.q, guess, directions, data.clearance_margin_m, data.reach_m)
    parts = [limit.program_part(at_nodes) for limit in data.limits]
    legs = one_way_legs(data.limits, guess, data.mesh.s, data.mesh.knots)
    return ProgramPart(
        unknowns=tuple(own for part in parts for own in part.unknowns),
        rows=(
            *node_rows(guess.machine, data.mesh, x.pose, x.q, x.coefficients),
            *(row for part in parts for row in part.rows),
            *side_rows(guess.machine, data.corridor, x.pose, x.q),
            *wall_rows(data.corridor.walls, x.pose),
            *one_way_rows(legs, x.coefficients),
        ),
    )


def node_unknowns(
    data: NodeData, guess: PoseSamples, coefficients: tuple[FloatArray, FloatArray, FloatArray], x: Symbols
) -> list[Unknowns]:
    """List the unknowns of `Symbols` with guess and bounds; those of the coefficients (n, 5) are given."""
    free = np.full_like(guess.q_m, np.inf)
    return [
        Unknowns(x.pose, guess.pose, data.corridor.low, data.corridor.high),
        Unknowns(x.q, guess.q_m, -free, free),
        Unknowns(x.coefficients, *coefficients),
    ]


def assemble(
    unknowns: Sequence[Unknowns], rows: Sequence[Row], x: Symbols, kappa: NodeKappa, distance: ca.MX, written: Written
) -> Program:
    """Put a program together of its unknowns, those of `node_unknowns` first, and its rows.

    Parameters
    ----------
    distance : (1, k - 1)
        Distances of neighbouring nodes: the integral of kappa over them is the trapezoidal rule.
    written : callable
        Writes the objective, and the rows that depend on kappa.
    """
    vector, nodes = ca.veccat(*(part.symbol for part in unknowns)), ca.vertcat(x.pose, x.q[:3, :])
    trapezoids = (ca.horzcat(distance, 0.0) + ca.horzcat(0.0, distance)) / 2.0

    def whole(kappas: ca.MX) -> tuple[ca.MX, ca.MX, list[Row]]:
        f, more = written(kappas, ca.dot(kappas, trapezoids))
        every = [*rows, *more]
        return f, ca.vertcat(*(row.expression for row in every)), every

    kappas = kappa(nodes)[0]
    f, g, every = whole(kappas)
    return Program(
        problem={"x": vector, "f": f, "g": g},
        derivatives=derivative_options(kappa, nodes, vector, lambda kappas: whole(kappas)[:2]),
        integral=ca.Function("integral", [vector], [ca.dot(kappas, trapezoids)]),
        variable_bounds=(_joined(part.low for part in unknowns), _joined(part.high for part in unknowns)),
        constraint_bounds=(
            _joined(np.full(row.expression.numel(), row.low) for row in every),
            _joined(np.full(row.expression.numel(), row.high) for row in every),
        ),
        guess=_joined(part.guess for part in unknowns),
        blocks=_blocks(every),
        nodes=int(x.pose.shape[1]),
        coefficients=int(x.coefficients.shape[1]),
        kappa=kappa,
    )


def _blocks(rows: Sequence[Row]) -> tuple[Block, ...]:
    ends = np.cumsum([row.expression.numel() for row in rows]).tolist()
    return tuple(Block(row.name, *span) for row, span in zip(rows, pairwise([0, *ends]), strict=True))


def _joined(parts: Iterable[FloatArray]) -> FloatArray:
    return np.concatenate([np.ravel(part) for part in parts])
