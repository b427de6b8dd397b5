"""The nonlinear program of the least integral of kappa, written in CasADi.

    minimise    the integral of kappa: over neighbouring nodes, (kappa_k + kappa_k+1) / 2 times their distance in
                the route's metric
                + evenness times the variance of the speed along s times the length
    subject to  closure(pose_k, q_k) = 0,  q_k = basis(s_k) . coefficients,
                corridor, strokes and travel (bounds of the coefficients hold everywhere: convex hull),
                0.5 <= speed along s relative to the mean <= 1.5, actuators moving at both ends,
                the rows of every limit at the nodes,
                every cart on its side of the platform, the TCP behind the walls of straight ends,
                the first and the last leg of the splines' control polygon along given directions.

Beyond the unknowns of every program over nodes it has the length.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array

from pipeline.arrays import FloatArray
from pipeline.limits.interface.rows import Row, Unknowns
from pipeline.machine.samples import PoseSamples
from pipeline.refine.collocation.data import NodeData
from pipeline.refine.collocation.node_kappa import NodeKappa
from pipeline.refine.collocation.program import (
    Distances,
    Program,
    Symbols,
    assemble,
    distances,
    node_part,
    node_unknowns,
)
from pipeline.refine.collocation.rows import direction_rows, sparse
from pipeline.refine.mesh import Mesh
from pipeline.refine.splines import DEGREE
from pipeline.route.metric import arc_length

SPEED_RANGE = (0.5, 1.5)
"""Speed along s relative to its mean: without it the optimum rushes through where kappa is high."""
END_SPEED = 0.3
"""Least speed of the actuators at start and goal, relative to that up to the next node."""
_SMOOTHING = 1e-4
"""Share of the mean distance between nodes, added in quadrature."""
_LEAST_LENGTH = 1e-3


@dataclass(frozen=True, eq=False)
class InitialGuess:
    """Where the solver starts: poses and actuators of the k nodes, coefficients (n, 5)."""

    nodes: PoseSamples
    coefficients: FloatArray


@dataclass(frozen=True, eq=False)
class ProgramData:
    """What a program is written for.

    Attributes
    ----------
    nodes : NodeData
        What its nodes have to keep.
    exponent : float
        Exponent of the smooth kappa, a Schatten condition number.
    evenness : float
        Cost of uneven speed along s, in units of kappa: the integral alone leaves the nodes free, and IPOPT creeps.
    smoothness : (5 n, 5 n)
        Form of the cost of a path that is not smooth.
    """

    nodes: NodeData
    exponent: float
    evenness: float
    smoothness: csr_array


def build_program(data: ProgramData, guess: InitialGuess) -> Program:
    """Write the program of a mesh, to be started from a guess."""
    nodes, mesh = data.nodes, data.nodes.mesh
    x, length = Symbols.of(nodes), ca.MX.sym("length")
    first_length = float(arc_length(guess.nodes.pose, nodes.steps)[-1])
    between = distances(nodes, guess.nodes, x, _SMOOTHING)
    part = node_part(nodes, guess.nodes, BSpline(mesh.knots, guess.coefficients, DEGREE), x)
    unknowns = [
        *node_unknowns(nodes, guess.nodes, _coefficients(nodes, guess), x),
        *part.unknowns,
        Unknowns(length, np.array([first_length]), np.array([_LEAST_LENGTH]), np.array([np.inf])),
    ]
    rows = [
        *part.rows,
        *_path_rows(mesh, length, between),
        *_end_speeds(mesh, x),
        *direction_rows(nodes.directions, _end_legs(x.coefficients)),
    ]
    rest = data.evenness * _unevenness(mesh, between.smooth, length, first_length)
    rest += ca.bilin(sparse(data.smoothness), ca.vec(x.coefficients), ca.vec(x.coefficients))
    kappa = NodeKappa(guess.nodes.machine, len(mesh.s), data.exponent)
    return assemble(unknowns, rows, x, kappa, between.smooth, lambda kappas, integral: (integral + rest, []))


def _coefficients(data: NodeData, guess: InitialGuess) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give guess and bounds of the coefficients; those at both ends are given."""
    low, high = (np.tile(bound, (len(guess.coefficients), 1)) for bound in data.actuator_range_m.T)
    low[[0, -1]] = high[[0, -1]] = guess.coefficients[[0, -1]]
    return guess.coefficients, low, high


def _path_rows(mesh: Mesh, length: ca.MX, between: Distances) -> list[Row]:
    """Write the speed along s and the length."""
    fraction = ca.DM(np.diff(mesh.s)).T * length
    least, largest = SPEED_RANGE
    return [
        Row("speed along the path (least)", ca.vec(between.squared - (least * fraction) ** 2), 0.0, np.inf),
        Row("speed along the path (largest)", ca.vec(between.squared - (largest * fraction) ** 2), -np.inf, 0.0),
        Row("length", length - ca.sum2(between.smooth), 0.0, 0.0),
    ]


def _end_speeds(mesh: Mesh, x: Symbols) -> list[Row]:
    """Write |q'|^2 at both ends less a share of the mean one up to the next node, squared: a spline may halt there."""
    s, t, c, q = mesh.s, mesh.knots, x.coefficients, x.q
    first = DEGREE * (c[:, 1] - c[:, 0]) / (t[DEGREE + 1] - t[0])
    last = DEGREE * (c[:, -1] - c[:, -2]) / (t[-1] - t[-DEGREE - 2])
    means = ((q[:, 1] - q[:, 0]) / (s[1] - s[0]), (q[:, -1] - q[:, -2]) / (s[-1] - s[-2]))
    ends = zip(("start", "goal"), (first, last), means, strict=True)
    return [
        Row(f"speed at the {name}", ca.sumsqr(end) - ca.sumsqr(END_SPEED * mean), 0.0, np.inf)
        for name, end, mean in ends
    ]


def _end_legs(coefficients: ca.MX) -> tuple[ca.MX, ca.MX]:
    """Return the first and the last leg of the control polygon."""
    return coefficients[:, 1] - coefficients[:, 0], coefficients[:, -1] - coefficients[:, -2]


def _unevenness(mesh: Mesh, distance: ca.MX, length: ca.MX, first_length: float) -> ca.MX:
    """Write the variance of the speed along s, in units of the guess's mean speed, times the guess's length."""
    ds = ca.DM(np.diff(mesh.s)).T
    deviation = (distance / ds - length) / first_length
    return first_length * ca.dot(ds, deviation**2)
