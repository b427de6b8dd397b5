"""The nonlinear program of path and time law together, written in CasADi.

    minimise    T / T_ref + w K / K_ref + a little jerk, with K the integral of kappa
    subject to  closure(pose_k, q_k) = 0,  q_k = basis(tau_k) . coefficients,
                rest without acceleration at both ends (three equal coefficients),
                |control coefficients of q', q'', q'''| <= T, T^2, T^3 times the limits of velocity, acceleration, jerk,
                log kappa_k <= log cap,
                forces and the motion of the TCP within their limits at nodes that come near (`load_rows`),
                corridor, strokes and travel, the rows of every limit at the nodes, the sides of the carts,
                directions at the ends, every visit at a time of its own.

Unknowns are those of the program over s, with T relative to its guess instead of the length: tau is time, so that
nothing is left open that evenness would have to settle.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import casadi as ca
import numpy as np
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray
from pipeline.limits import NodeLimit
from pipeline.limits.interface.rows import Nodes, Row, Unknowns
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import CONTROLLED
from pipeline.machine.samples import PoseSamples
from pipeline.refine.corridor.cells import Corridor
from pipeline.refine.integral.derivatives import derivative_options
from pipeline.refine.integral.node_kappa import NodeKappa
from pipeline.refine.integral.program import Block, Program
from pipeline.refine.integral.rows import direction_rows, node_rows, one_way_rows, side_rows, sparse
from pipeline.refine.integral.wall_rows import wall_rows
from pipeline.refine.mesh import Mesh
from pipeline.refine.one_way import one_way_legs
from pipeline.refine.result import Path, directions_of
from pipeline.refine.splines import DEGREE
from pipeline.refine.timed.first_motion import AT_REST, locked
from pipeline.refine.timed.hull import derivative_matrix, rate_limits
from pipeline.refine.timed.load_rows import TimedSymbols, load_part
from pipeline.refine.timed.visits import VisitBounds, VisitNodes, VisitPart, visit_part
from pipeline.route.metric import arc_length

_SMOOTHING = 1e-3
"""Share of the mean distance between nodes, added in quadrature: near rest nodes hardly differ."""
_JERK = 1e-4
"""Weight of the mean square of jerk relative to its limit: it settles what the duration leaves open."""
_STILL_M = 1e-9
"""Travel of an actuator that counts as none."""
_LEAST_TIME, _MOST_TIME = 0.2, 5.0
"""Bounds of T relative to its guess."""


@dataclass(frozen=True, eq=False)
class TimedData:
    """What a program is written for; attributes that `ProgramData` has, too, are explained there.

    Attributes
    ----------
    log_cap : (k,)
        Logarithm of the largest kappa of every node; infinite where kappa is given.
    visit_bounds : VisitBounds
        Bounds of the visits.
    weights : (float, float)
        1 / T_ref in 1/s, and w / K_ref.
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
    log_cap: FloatArray
    visit_bounds: VisitBounds
    weights: tuple[float, float]


@dataclass(frozen=True, eq=False)
class TimedGuess:
    """Where the solver starts: a motion q(tau) with its duration, its poses known at the k nodes, and the visits."""

    path: Path
    visits: VisitNodes

    @cached_property
    def nodes(self) -> PoseSamples:
        """The machine at the nodes."""
        return PoseSamples(self.path.machine, self.path.node_pose, self.path.q(self.path.node_s))

    @property
    def spline(self) -> BSpline:
        """The splines q(tau)."""
        return self.path.spline

    @property
    def motion_s(self) -> float:
        """T in seconds."""
        return float(self.path.motion_s or np.nan)


@dataclass(frozen=True, eq=False)
class TimedProgram:
    """A program for a solver, and how to read what it has beyond that over s.

    Attributes
    ----------
    program : Program
        The program.
    motion : ca.Function
        x -> T in seconds.
    visit_shares, visit_poses : ca.Function
        x -> share of each visit within its knot span, (1, v); x -> their poses, (6, v).
    spans : (v, 2)
        The knot spans.
    """

    program: Program
    motion: ca.Function
    visit_shares: ca.Function
    visit_poses: ca.Function
    spans: FloatArray


def build_timed_program(data: TimedData, guess: TimedGuess) -> TimedProgram:
    """Write the program of a mesh, to be started from a guess."""
    machine, k, n = guess.path.machine, len(data.mesh.s), data.mesh.coefficients
    x = TimedSymbols(ca.MX.sym("pose", 6, k), ca.MX.sym("q", 5, k), ca.MX.sym("c", 5, n), ca.MX.sym("time"))
    directions = directions_of(guess.spline(data.mesh.s, nu=1))
    at_nodes = Nodes(x.pose, x.q, guess.nodes, directions, data.clearance_margin_m, data.reach_m)
    parts = [limit.program_part(at_nodes) for limit in data.limits]
    visits = visit_part(machine, guess.visits, data.visit_bounds, guess.spline, x.coefficients)
    parts.append(load_part(guess.path, data.mesh.s, x))
    own = [unknown for part in parts for unknown in part.unknowns]
    unknowns = [*_unknowns(data, guess, x), *own, *visits.unknowns, _time(x)]
    c = x.coefficients
    legs = c[:, AT_REST] - c[:, AT_REST - 1], c[:, -AT_REST] - c[:, -AT_REST - 1]
    rows = [
        *node_rows(machine, data.mesh, x.pose, x.q, c),
        *_rate_rows(machine, data.mesh, x, guess.motion_s),
        *(row for part in parts for row in part.rows),
        *side_rows(machine, data.corridor, x.pose, x.q),
        *wall_rows(data.corridor.walls, x.pose),
        *direction_rows(data.directions, legs),
        *one_way_rows(one_way_legs(data.limits, guess.nodes, data.mesh.s, data.mesh.knots), c),
        *visits.rows,
    ]
    vector, g = ca.veccat(*(part.symbol for part in unknowns)), ca.vertcat(*(row.expression for row in rows))
    nodes, kappa = ca.vertcat(x.pose, x.q[:3, :]), NodeKappa(machine, k, data.exponent)
    distance = _distances(data.steps, x.pose, guess.nodes.pose)
    trapezoids = (ca.horzcat(distance, 0.0) + ca.horzcat(0.0, distance)) / 2.0
    capped = np.flatnonzero(np.isfinite(data.log_cap)).tolist()
    by_time, by_kappa = data.weights
    rest = by_time * guess.motion_s * x.time + _JERK * _mean_square_jerk(machine, data.mesh, x, guess)

    def written(kappas: ca.MX) -> tuple[ca.MX, ca.MX]:
        below_cap = ca.log(kappas[capped]) - ca.DM(data.log_cap[capped]).T
        return by_kappa * ca.dot(kappas, trapezoids) + rest, ca.vertcat(g, ca.vec(below_cap))

    kappas = kappa(nodes)[0]
    f, g_whole = written(kappas)
    rows = [*rows, Row("kappa above its cap", ca.MX(len(capped), 1), -np.inf, 0.0)]
    program = Program(
        problem={"x": vector, "f": f, "g": g_whole},
        derivatives=derivative_options(kappa, nodes, vector, written),
        integral=ca.Function("integral", [vector], [ca.dot(kappas, trapezoids)]),
        variable_bounds=(_joined([part.low for part in unknowns]), _joined([part.high for part in unknowns])),
        constraint_bounds=(
            _joined([np.full(row.expression.numel(), row.low) for row in rows]),
            _joined([np.full(row.expression.numel(), row.high) for row in rows]),
        ),
        guess=_joined([part.guess for part in unknowns]),
        blocks=_blocks(rows),
        nodes=k,
        coefficients=n,
        kappa=kappa,
    )
    return TimedProgram(
        program,
        ca.Function("motion", [vector], [guess.motion_s * x.time]),
        ca.Function("shares", [vector], [_symbol(visits, -1, 1)]),
        ca.Function("poses", [vector], [_symbol(visits, 0, 6)]),
        visits.spans,
    )


def _unknowns(data: TimedData, guess: TimedGuess, x: TimedSymbols) -> list[Unknowns]:
    """List nodes and coefficients; those at rest are given, and so are those of actuators that must not move."""
    nodes, c = guess.nodes, guess.spline.c
    low, high = (np.tile(bound, (len(c), 1)) for bound in data.actuator_range_m.T)
    given = np.zeros(c.shape, dtype=bool)
    given[:AT_REST] = given[-AT_REST:] = True
    low[given] = high[given] = c[given]
    still = locked(nodes.machine) & (np.ptp(c, axis=0) < _STILL_M)
    low[:, still] = high[:, still] = c[0, still]
    free = np.full_like(nodes.q_m, np.inf)
    return [
        Unknowns(x.pose, nodes.pose, data.corridor.low, data.corridor.high),
        Unknowns(x.q, nodes.q_m, -free, free),
        Unknowns(x.coefficients, c, low, high),
    ]


def _time(x: TimedSymbols) -> Unknowns:
    return Unknowns(x.time, np.ones(1), np.array([_LEAST_TIME]), np.array([_MOST_TIME]))


def _rate_rows(machine: Machine, mesh: Mesh, x: TimedSymbols, motion_s: float) -> list[Row]:
    """Write the control coefficients of q', q'' and q''' relative to their limits at T, within -1 and 1."""
    rows = []
    for limit in rate_limits(machine):
        kept = np.flatnonzero(np.isfinite(limit.largest))
        if len(kept):
            scale = ca.DM(np.diag(1.0 / (limit.largest[kept] * motion_s**limit.order)))
            matrix = sparse(derivative_matrix(mesh.knots, DEGREE, limit.order))
            rates = scale @ x.coefficients[kept.tolist(), :] @ matrix.T
            rows.append(Row(limit.name, ca.vec(rates) / x.time**limit.order, -1.0, 1.0))
    return rows


def _mean_square_jerk(machine: Machine, mesh: Mesh, x: TimedSymbols, guess: TimedGuess) -> ca.MX:
    """Write the mean square of the control coefficients of jerk at the guess's T, relative to the limits.

    Where there is no limit, to the largest of the guess.
    """
    matrix, limit = derivative_matrix(mesh.knots, DEGREE, 3), rate_limits(machine)[2].largest
    largest = np.abs(matrix @ guess.spline.c).max(axis=0) / guess.motion_s**3
    scale = np.where(np.isfinite(limit), limit, np.where(largest > 0.0, largest, 1.0))
    jerk = ca.DM(np.diag(1.0 / (scale * guess.motion_s**3))) @ x.coefficients @ sparse(matrix).T
    return ca.sumsqr(jerk) / jerk.numel()


def _distances(steps: FloatArray, pose: ca.MX, guess: FloatArray) -> ca.MX:
    """Write the distances between neighbouring nodes in the metric of the route. Shape (1, k - 1)."""
    moves = (pose[list(CONTROLLED), 1:] - pose[list(CONTROLLED), :-1]) / ca.DM(steps)
    mean = float(arc_length(guess, steps)[-1]) / len(guess)
    return ca.sqrt(ca.sum1(moves**2) + (_SMOOTHING * mean) ** 2)


def _symbol(visits: VisitPart, number: int, rows: int) -> ca.MX:
    return visits.unknowns[number].symbol if visits.unknowns else ca.MX(rows, 0)


def _blocks(rows: Sequence[Row]) -> tuple[Block, ...]:
    ends = np.cumsum([row.expression.numel() for row in rows]).tolist()
    return tuple(Block(row.name, *span) for row, span in zip(rows, pairwise([0, *ends]), strict=True))


def _joined(parts: Sequence[FloatArray]) -> FloatArray:
    return np.concatenate([np.ravel(part) for part in parts])
