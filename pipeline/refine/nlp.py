"""The nonlinear program of stage two, written in CasADi.

Unknowns: pose (6) and actuators (5) of every collocation node, the spline coefficients, a separating vector for
every pair of links that comes near, and the length. With the actuators as unknowns of their own the Hessian is
sparse: a node touches itself and its neighbour, and the splines only enter linear equations.

    minimise    sum over neighbouring nodes of (kappa_k + kappa_k+1) / 2 times their distance in the route's metric
    subject to  closure(pose_k, q_k) = 0,  q_k = basis(s_k) . coefficients,
                corridor, strokes and travel (bounds of the coefficients hold everywhere: convex hull),
                0.5 <= speed along s relative to the mean <= 1.5,
                n . (a - b) >= clearance,  n . n <= 1.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.sparse import csr_array

from pipeline.machine.geometry import FloatArray, Machine
from pipeline.machine.symbolic import Smooth, closure_function, kappa_function
from pipeline.refine.corridor import Corridor
from pipeline.refine.hessian import lagrangian_hessian
from pipeline.refine.separation import Separations, apartness
from pipeline.refine.splines import basis
from pipeline.route.metric import CONTROLLED

SPEED_RANGE = (0.5, 1.5)
"""Speed along s relative to its mean: without it the optimum rushes through where kappa is high."""


@dataclass(frozen=True, eq=False)
class Start:
    """Where the solver starts: poses (k, 6), coefficients (n, 5)."""

    pose: FloatArray
    coefficients: FloatArray


@dataclass(frozen=True, eq=False)
class Block:
    """A named group of constraints: rows of g from `begin` on, for messages that say what is violated."""

    name: str
    begin: int
    end: int


@dataclass(frozen=True, eq=False)
class Program:
    """A nonlinear program ready for a solver: CasADi expressions, bounds, start, and how to read its solution."""

    problem: dict[str, ca.MX]
    hessian: ca.Function
    variable_bounds: tuple[FloatArray, FloatArray]
    constraint_bounds: tuple[FloatArray, FloatArray]
    start: FloatArray
    blocks: tuple[Block, ...]
    nodes: int
    coefficients: int

    def poses(self, x: FloatArray) -> FloatArray:
        """Poses of the nodes in a solution vector, shape (nodes, 6)."""
        return x[: 6 * self.nodes].reshape(self.nodes, 6)

    def spline_coefficients(self, x: FloatArray) -> FloatArray:
        """Spline coefficients in a solution vector, shape (coefficients, 5)."""
        begin = 11 * self.nodes
        return x[begin : begin + 5 * self.coefficients].reshape(self.coefficients, 5)


@dataclass(frozen=True, eq=False)
class Setting:
    """What one solve is about: nodes s (k,), knots, corridor, separations, the metric (5,) and the kind of kappa."""

    s: FloatArray
    knots: FloatArray
    corridor: Corridor
    separations: Separations
    steps: FloatArray
    kind: Smooth


def build_program(machine: Machine, setting: Setting, start: Start) -> Program:
    """Write the program for given nodes, corridor and separations, to be started from `start`."""
    k, n, m = len(setting.s), len(start.coefficients), len(setting.separations)
    pose, q, coefficients = ca.MX.sym("pose", 6, k), ca.MX.sym("q", 5, k), ca.MX.sym("c", 5, n)
    normal, length = ca.MX.sym("n", 3, m), ca.MX.sym("length")
    B = basis(setting.knots, setting.s)
    moves = (pose[list(CONTROLLED), 1:] - pose[list(CONTROLLED), :-1]) / ca.DM(setting.steps)
    squared = ca.sum1(moves**2)
    distance = ca.sqrt(squared)
    fraction = ca.DM(np.diff(setting.s)).T * length
    groups = [
        ("closure", ca.vec(closure_function(machine).map(k)(pose, q)), 0.0, 0.0),
        ("spline", ca.vec(q - coefficients @ _sparse(B).T), 0.0, 0.0),
        ("speed along the path (least)", ca.vec(squared - (SPEED_RANGE[0] * fraction) ** 2), 0.0, np.inf),
        ("speed along the path (largest)", ca.vec(squared - (SPEED_RANGE[1] * fraction) ** 2), -np.inf, 0.0),
        ("length", length - ca.sum2(distance), 0.0, 0.0),
        ("clearance", apartness(machine, setting.separations, pose, q, normal), 0.0, np.inf),
        ("separating vectors", ca.vec(ca.sum1(normal**2)), -np.inf, 1.0),
    ]
    sizes = [expression.numel() for _, expression, _, _ in groups]
    ends = np.cumsum(sizes)
    x = ca.veccat(pose, q, coefficients, normal, length)
    g = ca.vertcat(*(expression for _, expression, _, _ in groups))
    kappa = kappa_function(machine, setting.kind)
    weights = (ca.horzcat(distance, 0.0) + ca.horzcat(0.0, distance)) / 2.0
    return Program(
        problem={"x": x, "f": ca.dot(kappa.map(k)(pose, q), weights), "g": g},
        hessian=lagrangian_hessian(kappa, pose, q, weights, x, g),
        variable_bounds=_variable_bounds(machine, setting, start),
        constraint_bounds=(
            np.repeat([low for _, _, low, _ in groups], sizes),
            np.repeat([high for _, _, _, high in groups], sizes),
        ),
        start=_start_vector(setting, start, B),
        blocks=tuple(
            Block(name, int(end) - size, int(end))
            for (name, _, _, _), size, end in zip(groups, sizes, ends, strict=True)
        ),
        nodes=k,
        coefficients=n,
    )


def _variable_bounds(machine: Machine, setting: Setting, start: Start) -> tuple[FloatArray, FloatArray]:
    nodes, pairs = len(setting.s), len(setting.separations)
    limits = machine.actuator_limits_m
    coefficient_low = np.tile(limits[:, 0], (len(start.coefficients), 1))
    coefficient_high = np.tile(limits[:, 1], (len(start.coefficients), 1))
    coefficient_low[[0, -1]] = coefficient_high[[0, -1]] = start.coefficients[[0, -1]]
    normal_high = np.full((pairs, 3), np.inf)
    normal_high[setting.separations.of_rail, 0] = 0.0
    low = (setting.corridor.low, np.full(5 * nodes, -np.inf), coefficient_low, -normal_high, [1e-3])
    high = (setting.corridor.high, np.full(5 * nodes, np.inf), coefficient_high, normal_high, [np.inf])
    return (np.concatenate([np.ravel(part) for part in low]), np.concatenate([np.ravel(part) for part in high]))


def _start_vector(setting: Setting, start: Start, B: csr_array) -> FloatArray:
    moves = np.diff(start.pose[:, CONTROLLED], axis=0) / setting.steps
    length = np.linalg.norm(moves, axis=1).sum()
    q = B @ start.coefficients
    parts = (start.pose, q, start.coefficients, setting.separations.normal, [length])
    return np.concatenate([np.ravel(part) for part in parts])


def _sparse(matrix: csr_array) -> ca.DM:
    triplets = matrix.tocoo()
    return ca.DM.triplet(triplets.row.tolist(), triplets.col.tolist(), ca.DM(triplets.data), *matrix.shape)
