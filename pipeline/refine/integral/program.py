"""The nonlinear program of stage two, written in CasADi.

Unknowns: pose (6) and actuators (5) of every collocation node, spline coefficients, what limits bring, and the length.
With the actuators as unknowns of their own the Hessian is sparse: a node touches itself and its neighbour.

    minimise    the integral of kappa: over neighbouring nodes, (kappa_k + kappa_k+1) / 2 times their distance in
                the route's metric
                + evenness times the variance of the speed along s times the length
    subject to  closure(pose_k, q_k) = 0,  q_k = basis(s_k) . coefficients,
                corridor, strokes and travel (bounds of the coefficients hold everywhere: convex hull),
                0.5 <= speed along s relative to the mean <= 1.5, actuators moving at both ends,
                the rows of every limit at the nodes,
                every cart on its side of the platform,
                the first and the last leg of the splines' control polygon along given directions.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import casadi as ca
import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array

from pipeline.arrays import FloatArray
from pipeline.limits import NodeLimit
from pipeline.limits.interface.rows import Nodes, Row, Unknowns
from pipeline.machine.pose import CONTROLLED
from pipeline.machine.samples import PoseSamples
from pipeline.refine.corridor.cells import Corridor
from pipeline.refine.integral.derivatives import derivative_options
from pipeline.refine.integral.node_kappa import NodeKappa
from pipeline.refine.integral.rows import direction_rows, node_rows, one_way_rows, side_rows, sparse
from pipeline.refine.mesh import Mesh
from pipeline.refine.one_way import one_way_legs
from pipeline.refine.result import directions_of
from pipeline.refine.splines import DEGREE
from pipeline.route.metric import arc_length

SPEED_RANGE = (0.5, 1.5)
"""Speed along s relative to its mean: without it the optimum rushes through where kappa is high."""
END_SPEED = 0.3
"""Least speed of the actuators at start and goal, relative to that up to the next node."""
_SMOOTHING = 1e-4
"""Share of the mean distance between nodes, added in quadrature: a distance of zero has no derivative."""
_LEAST_LENGTH = 1e-3


@dataclass(frozen=True, eq=False)
class InitialGuess:
    """Where the solver starts: poses and actuators of the k nodes, coefficients (n, 5)."""

    nodes: PoseSamples
    coefficients: FloatArray


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
class ProgramData:
    """What a program is written for.

    Attributes
    ----------
    mesh : Mesh
        Nodes, k of them, and knots.
    corridor : Corridor
        Bounds of the poses.
    limits : sequence of NodeLimit
        What nodes have to keep.
    clearance_margin_m, reach_m : float
        What nodes keep on top of distances, and how near to a limit something has to come to get a row.
    steps : (5,)
        The metric: largest moves per step of the route.
    directions : (2, 5)
        Unit vectors in which the actuators leave the start and reach the goal, NaN where they are free.
    actuator_range_m : (5, 2)
        Least and largest position of every actuator along the path.
    exponent : float
        Exponent of the smooth kappa, a Schatten condition number.
    evenness : float
        Cost of uneven speed along s, in units of kappa: the integral alone leaves the nodes free, and IPOPT creeps.
    smoothness : (5 n, 5 n)
        Form of the cost of a path that is not smooth.
    """

    mesh: Mesh
    corridor: Corridor
    limits: Sequence[NodeLimit]
    clearance_margin_m: float
    reach_m: float
    steps: FloatArray
    directions: FloatArray
    actuator_range_m: FloatArray
    exponent: float
    evenness: float
    smoothness: csr_array


@dataclass(frozen=True, eq=False)
class _Symbols:
    """Unknowns of the program: pose (6, k), q (5, k), coefficients (5, n), length (1, 1)."""

    pose: ca.MX
    q: ca.MX
    coefficients: ca.MX
    length: ca.MX


def build_program(data: ProgramData, guess: InitialGuess) -> Program:
    """Write the program of a mesh, to be started from a guess."""
    machine, k, n = guess.nodes.machine, len(data.mesh.s), data.mesh.coefficients
    x = _Symbols(ca.MX.sym("pose", 6, k), ca.MX.sym("q", 5, k), ca.MX.sym("c", 5, n), ca.MX.sym("length"))
    first_length = float(arc_length(guess.nodes.pose, data.steps)[-1])
    moves = (x.pose[list(CONTROLLED), 1:] - x.pose[list(CONTROLLED), :-1]) / ca.DM(data.steps)
    squared = ca.sum1(moves**2)
    distance = ca.sqrt(squared + (_SMOOTHING * first_length / k) ** 2)
    directions = directions_of(BSpline(data.mesh.knots, guess.coefficients, DEGREE)(data.mesh.s, nu=1))
    at_nodes = Nodes(x.pose, x.q, guess.nodes, directions, data.clearance_margin_m, data.reach_m)
    parts = [limit.program_part(at_nodes) for limit in data.limits]
    unknowns = _unknowns(data, guess, x, [own for part in parts for own in part.unknowns], first_length)
    rows = [
        *node_rows(machine, data.mesh, x.pose, x.q, x.coefficients),
        *_path_rows(data.mesh, x, squared, distance),
        *(row for part in parts for row in part.rows),
        *side_rows(machine, data.corridor, x.pose, x.q),
        *_end_speeds(data.mesh, x),
        *direction_rows(data.directions, _end_legs(x.coefficients)),
        *one_way_rows(one_way_legs(data.limits, guess.nodes, data.mesh.s, data.mesh.knots), x.coefficients),
    ]
    vector, g = ca.veccat(*(part.symbol for part in unknowns)), ca.vertcat(*(row.expression for row in rows))
    nodes, kappa = ca.vertcat(x.pose, x.q[:3, :]), NodeKappa(machine, k, data.exponent)
    trapezoids = (ca.horzcat(distance, 0.0) + ca.horzcat(0.0, distance)) / 2.0
    rest = data.evenness * _unevenness(data.mesh, distance, x.length, first_length)
    rest += ca.bilin(sparse(data.smoothness), ca.vec(x.coefficients), ca.vec(x.coefficients))

    def written(kappas: ca.MX) -> tuple[ca.MX, ca.MX]:
        return ca.dot(kappas, trapezoids) + rest, g

    kappas = kappa(nodes)[0]
    return Program(
        problem={"x": vector, "f": written(kappas)[0], "g": g},
        derivatives=derivative_options(kappa, nodes, vector, written),
        integral=ca.Function("integral", [vector], [ca.dot(kappas, trapezoids)]),
        variable_bounds=(_joined(part.low for part in unknowns), _joined(part.high for part in unknowns)),
        constraint_bounds=(
            _joined(np.full(row.expression.numel(), row.low) for row in rows),
            _joined(np.full(row.expression.numel(), row.high) for row in rows),
        ),
        guess=_joined(part.guess for part in unknowns),
        blocks=_blocks(rows),
        nodes=k,
        coefficients=n,
        kappa=kappa,
    )


def _unknowns(
    data: ProgramData, guess: InitialGuess, x: _Symbols, own: list[Unknowns], first_length: float
) -> list[Unknowns]:
    """List all unknowns with guess and bounds; `own` are those of the limits."""
    nodes, count = guess.nodes, len(guess.coefficients)
    low, high = (np.tile(bound, (count, 1)) for bound in data.actuator_range_m.T)
    low[[0, -1]] = high[[0, -1]] = guess.coefficients[[0, -1]]
    free = np.full_like(nodes.q_m, np.inf)
    return [
        Unknowns(x.pose, nodes.pose, data.corridor.low, data.corridor.high),
        Unknowns(x.q, nodes.q_m, -free, free),
        Unknowns(x.coefficients, guess.coefficients, low, high),
        *own,
        Unknowns(x.length, np.array([first_length]), np.array([_LEAST_LENGTH]), np.array([np.inf])),
    ]


def _path_rows(mesh: Mesh, x: _Symbols, squared: ca.MX, distance: ca.MX) -> list[Row]:
    """Write the speed along s and the length."""
    fraction = ca.DM(np.diff(mesh.s)).T * x.length
    least, largest = SPEED_RANGE
    return [
        Row("speed along the path (least)", ca.vec(squared - (least * fraction) ** 2), 0.0, np.inf),
        Row("speed along the path (largest)", ca.vec(squared - (largest * fraction) ** 2), -np.inf, 0.0),
        Row("length", x.length - ca.sum2(distance), 0.0, 0.0),
    ]


def _end_speeds(mesh: Mesh, x: _Symbols) -> list[Row]:
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


def _blocks(rows: Sequence[Row]) -> tuple[Block, ...]:
    ends = np.cumsum([row.expression.numel() for row in rows]).tolist()
    return tuple(Block(row.name, *span) for row, span in zip(rows, pairwise([0, *ends]), strict=True))


def _joined(parts: Iterable[FloatArray]) -> FloatArray:
    return np.concatenate([np.ravel(part) for part in parts])
