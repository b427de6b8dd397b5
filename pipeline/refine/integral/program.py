"""The nonlinear program of stage two, written in CasADi.

Unknowns: pose (6) and actuators (5) of every collocation node, the spline coefficients, a separating vector for
every pair of links that comes near, and the length. With the actuators as unknowns of their own the Hessian is
sparse: a node touches itself and its neighbour, and the splines only enter linear equations.

    minimise    the integral of kappa: over neighbouring nodes, (kappa_k + kappa_k+1) / 2 times their distance in
                the route's metric
                + evenness times the variance of the speed along s times the length
    subject to  closure(pose_k, q_k) = 0,  q_k = basis(s_k) . coefficients,
                corridor, strokes and travel (bounds of the coefficients hold everywhere: convex hull),
                0.5 <= speed along s relative to the mean <= 1.5, actuators moving at both ends,
                n . (a - b) >= clearance,  n . n <= 1,
                every cart on its side of the platform,
                the first and the last leg of the splines' control polygon along given directions.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.linalg import null_space
from scipy.sparse import csr_array

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import PRIMARY, Machine
from pipeline.machine.symbolic import closure_function, joints_function
from pipeline.refine.corridor import Corridor
from pipeline.refine.integral.derivatives import derivative_options
from pipeline.refine.integral.node_kappa import NodeKappa
from pipeline.refine.integral.separation import Separations, apartness
from pipeline.refine.splines import DEGREE, basis
from pipeline.route.metric import CONTROLLED, arc_length

SPEED_RANGE = (0.5, 1.5)
"""Speed along s relative to its mean: without it the optimum rushes through where kappa is high."""

END_SPEED = 0.3
"""Least speed of the actuators at start and goal, relative to that up to the next node."""
_STILL = 1e-4
"""Share of the mean distance between nodes, added in quadrature: a distance of zero has no derivative."""


@dataclass(frozen=True, eq=False)
class InitialGuess:
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
    """A nonlinear program ready for a solver: CasADi expressions, bounds, start, and how to read its solution.

    `derivatives` are those of `derivatives.derivative_options`; `integral` gives the integral of the smooth kappa;
    `kappa` is what computes it, and has to live as long as the program.
    """

    problem: dict[str, ca.MX]
    derivatives: dict[str, ca.Function]
    integral: ca.Function
    variable_bounds: tuple[FloatArray, FloatArray]
    constraint_bounds: tuple[FloatArray, FloatArray]
    start: FloatArray
    blocks: tuple[Block, ...]
    nodes: int
    coefficients: int
    kappa: NodeKappa | None = None

    def poses(self, x: FloatArray) -> FloatArray:
        """Poses of the nodes in a solution vector, shape (nodes, 6)."""
        return x[: 6 * self.nodes].reshape(self.nodes, 6)

    def spline_coefficients(self, x: FloatArray) -> FloatArray:
        """Spline coefficients in a solution vector, shape (coefficients, 5)."""
        begin = 11 * self.nodes
        return x[begin : begin + 5 * self.coefficients].reshape(self.coefficients, 5)


@dataclass(frozen=True, eq=False)
class ProgramData:
    """What one solve is about.

    Attributes
    ----------
    s, knots : (k,), (n,)
        Parameters of the nodes; knots of the splines.
    corridor, separations : Corridor, Separations
        Bounds of the poses; what is kept apart.
    steps : (5,)
        The metric: largest moves per step of the route.
    exponent : float
        Of the smooth kappa, a Schatten condition number.
    directions : (2, 5)
        Unit vectors that the actuators leave the start and come to the goal in; not a number where they are free.
    evenness : float
        What uneven speed along s costs, in units of kappa. The integral itself does not change when a path is
        run through differently: without this cost nothing holds the nodes, and IPOPT creeps.
    """

    s: FloatArray
    knots: FloatArray
    corridor: Corridor
    separations: Separations
    steps: FloatArray
    exponent: float
    directions: FloatArray
    evenness: float


def build_program(machine: Machine, setting: ProgramData, start: InitialGuess) -> Program:
    """Write the program for given nodes, corridor and separations, to be started from `start`."""
    k, n, m = len(setting.s), len(start.coefficients), len(setting.separations)
    pose, q, coefficients = ca.MX.sym("pose", 6, k), ca.MX.sym("q", 5, k), ca.MX.sym("c", 5, n)
    normal, length = ca.MX.sym("n", 3, m), ca.MX.sym("length")
    B = basis(setting.knots, setting.s)
    moves = (pose[list(CONTROLLED), 1:] - pose[list(CONTROLLED), :-1]) / ca.DM(setting.steps)
    squared = ca.sum1(moves**2)
    distance = ca.sqrt(squared + (_STILL * _length(setting, start) / k) ** 2)
    fraction = ca.DM(np.diff(setting.s)).T * length
    trapezoids = (ca.horzcat(distance, 0.0) + ca.horzcat(0.0, distance)) / 2.0
    groups = [
        ("closure", ca.vec(closure_function(machine).map(k)(pose, q)), 0.0, 0.0),
        ("spline", ca.vec(q - coefficients @ _sparse(B).T), 0.0, 0.0),
        ("speed along the path (least)", ca.vec(squared - (SPEED_RANGE[0] * fraction) ** 2), 0.0, np.inf),
        ("speed along the path (largest)", ca.vec(squared - (SPEED_RANGE[1] * fraction) ** 2), -np.inf, 0.0),
        ("length", length - ca.sum2(distance), 0.0, 0.0),
        ("clearance", apartness(machine, setting.separations, pose, q, normal), 0.0, np.inf),
        ("separating vectors", ca.vec(ca.sum1(normal**2)), -np.inf, 1.0),
        ("sides of the carts", _sides(machine, setting.corridor, pose, q), setting.corridor.side_margin_m, np.inf),
        ("speed at the ends", _end_speeds(setting, q, coefficients), 0.0, np.inf),
        *_directions(setting.directions, coefficients),
    ]
    g = ca.vertcat(*(expression for _, expression, _, _ in groups))
    x = ca.veccat(pose, q, coefficients, normal, length)
    nodes, kappa = ca.vertcat(pose, q[:3, :]), NodeKappa(machine, k, setting.exponent)
    rest = setting.evenness * _unevenness(setting, start, distance, length)

    def objective(kappas: ca.MX) -> ca.MX:
        return ca.dot(kappas, trapezoids) + rest

    kappas = kappa(nodes)[0]
    sizes = [(name, expression.numel(), low, top) for name, expression, low, top in groups]
    ends = np.cumsum([size for _, size, _, _ in sizes])
    return Program(
        problem={"x": x, "f": objective(kappas), "g": g},
        derivatives=derivative_options(kappa, nodes, x, objective, g),
        integral=ca.Function("integral", [x], [ca.dot(kappas, trapezoids)]),
        variable_bounds=_variable_bounds(machine, setting, start),
        constraint_bounds=(
            np.concatenate([np.full(size, low) for _, size, low, _ in sizes]),
            np.concatenate([np.full(size, top) for _, size, _, top in sizes]),
        ),
        start=_start_vector(setting, start, B),
        blocks=tuple(
            Block(name, int(end) - size, int(end)) for (name, size, _, _), end in zip(sizes, ends, strict=True)
        ),
        nodes=k,
        coefficients=n,
        kappa=kappa,
    )


def _sides(machine: Machine, corridor: Corridor, pose: ca.MX, q: ca.MX) -> ca.MX:
    """Write side * (C_x - A_x) for the arms and nodes that have a side. Shape (entries,)."""
    nodes, arms = np.nonzero(corridor.sides)
    if len(nodes) == 0:
        return ca.MX(0, 1)
    platform, cart = (ca.vec(joints) for joints in joints_function(machine).map(pose.shape[1])(pose, q))
    # Of every node 18 entries by columns, x first.
    rows = (18 * nodes + PRIMARY[arms]).tolist()
    return ca.DM(corridor.sides[nodes, arms]) * (cart[rows] - platform[rows])


def _end_speeds(setting: ProgramData, q: ca.MX, coefficients: ca.MX) -> ca.MX:
    """Write |q'|^2 at both ends less a share of the mean one up to the next node, squared: a spline may halt there."""
    s, t = setting.s, setting.knots
    first = DEGREE * (coefficients[:, 1] - coefficients[:, 0]) / (t[DEGREE + 1] - t[0])
    last = DEGREE * (coefficients[:, -1] - coefficients[:, -2]) / (t[-1] - t[-DEGREE - 2])
    means = ((q[:, 1] - q[:, 0]) / (s[1] - s[0]), (q[:, -1] - q[:, -2]) / (s[-1] - s[-2]))
    rows = [ca.sumsqr(end) - ca.sumsqr(END_SPEED * mean) for end, mean in zip((first, last), means, strict=True)]
    speeds: ca.MX = ca.vertcat(*rows)
    return speeds


def _directions(directions: FloatArray, coefficients: ca.MX) -> list[tuple[str, ca.MX, float, float]]:
    """Write that a leg of the control polygon has nothing across its direction, and something along it."""
    legs = (coefficients[:, 1] - coefficients[:, 0], coefficients[:, -1] - coefficients[:, -2])
    groups = []
    for name, direction, leg in zip(("start", "goal"), directions, legs, strict=True):
        if np.isfinite(direction).all():
            across = null_space(direction[None]).T
            groups.append((f"direction at the {name}", ca.DM(across) @ leg, 0.0, 0.0))
            groups.append((f"way at the {name}", ca.dot(ca.DM(direction), leg), 0.0, np.inf))
    return groups


def _unevenness(setting: ProgramData, start: InitialGuess, distance: ca.MX, length: ca.MX) -> ca.MX:
    """Write the variance of the speed along s, in units of the start's mean speed, times the start's length."""
    first_length, ds = _length(setting, start), ca.DM(np.diff(setting.s)).T
    deviation = (distance / ds - length) / first_length
    return first_length * ca.dot(ds, deviation**2)


def _variable_bounds(machine: Machine, setting: ProgramData, start: InitialGuess) -> tuple[FloatArray, FloatArray]:
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


def _start_vector(setting: ProgramData, start: InitialGuess, B: csr_array) -> FloatArray:
    q = B @ start.coefficients
    parts = (start.pose, q, start.coefficients, setting.separations.normal, [_length(setting, start)])
    return np.concatenate([np.ravel(part) for part in parts])


def _length(setting: ProgramData, start: InitialGuess) -> float:
    return float(arc_length(start.pose, setting.steps)[-1])


def _sparse(matrix: csr_array) -> ca.DM:
    triplets = matrix.tocoo()
    return ca.DM.triplet(triplets.row.tolist(), triplets.col.tolist(), ca.DM(triplets.data), *matrix.shape)
