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

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray
from pipeline.limits.interface.rows import ProgramPart, Row, Unknowns
from pipeline.machine.geometry import Machine
from pipeline.machine.samples import PoseSamples
from pipeline.refine.collocation.data import NodeData
from pipeline.refine.collocation.node_kappa import NodeKappa
from pipeline.refine.collocation.program import Program, Symbols, assemble, distances, node_part, node_unknowns
from pipeline.refine.collocation.rows import direction_rows, sparse
from pipeline.refine.mesh import Mesh
from pipeline.refine.result import Path
from pipeline.refine.splines import DEGREE
from pipeline.refine.timed.first_motion import AT_REST, locked
from pipeline.refine.timed.hull import derivative_matrix, rate_limits
from pipeline.refine.timed.load_rows import Motion, load_part
from pipeline.refine.timed.visits import VisitBounds, VisitNodes, VisitPart, visit_part

_SMOOTHING = 1e-3
"""Share of the mean distance between nodes, added in quadrature: near rest nodes hardly differ."""
_JERK = 0.03
"""Weight of the mean square of jerk relative to its limit: it settles what the duration leaves open, which costs none
of it and a third of the changes of sign of accelerations."""
_STILL_M = 1e-9
"""Travel of an actuator that counts as none."""
_LEAST_TIME, _MOST_TIME = 0.2, 5.0
"""Bounds of T relative to its guess."""


@dataclass(frozen=True, eq=False)
class TimedData:
    """What a program is written for.

    Attributes
    ----------
    nodes : NodeData
        What its nodes have to keep.
    exponent : float
        Exponent of the smooth kappa, a Schatten condition number.
    log_cap : (k,)
        Logarithm of the largest kappa of every node; infinite where kappa is given.
    visit_bounds : VisitBounds
        Bounds of the visits.
    weights : (float, float)
        1 / T_ref in 1/s, and w / K_ref.
    """

    nodes: NodeData
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
    nodes, machine, mesh = data.nodes, guess.path.machine, data.nodes.mesh
    x, time = Symbols.of(nodes), ca.MX.sym("time")
    motion = Motion(x, time, guess.path)
    between = distances(nodes, guess.nodes, x, _SMOOTHING)
    visits = visit_part(machine, guess.visits, data.visit_bounds, guess.spline, x.coefficients)
    parts = [
        node_part(nodes, guess.nodes, guess.spline, x),
        load_part(motion, mesh.s),
        ProgramPart(visits.unknowns, visits.rows),
    ]
    c = x.coefficients
    legs = c[:, AT_REST] - c[:, AT_REST - 1], c[:, -AT_REST] - c[:, -AT_REST - 1]
    unknowns = [
        *node_unknowns(nodes, guess.nodes, _coefficients(nodes, guess), x),
        *(own for part in parts for own in part.unknowns),
        Unknowns(time, np.ones(1), np.array([_LEAST_TIME]), np.array([_MOST_TIME])),
    ]
    rows = [
        *(row for part in parts for row in part.rows),
        *_rate_rows(machine, mesh, motion),
        *direction_rows(nodes.directions, legs),
    ]
    capped = np.flatnonzero(np.isfinite(data.log_cap)).tolist()
    by_time, by_kappa = data.weights
    rest = by_time * guess.motion_s * time + _JERK * _mean_square_jerk(machine, mesh, x, guess)

    def written(kappas: ca.MX, integral: ca.MX) -> tuple[ca.MX, list[Row]]:
        below_cap = ca.log(kappas[capped]) - ca.DM(data.log_cap[capped]).T
        return by_kappa * integral + rest, [Row("kappa above its cap", ca.vec(below_cap), -np.inf, 0.0)]

    program = assemble(unknowns, rows, x, NodeKappa(machine, len(mesh.s), data.exponent), between.smooth, written)
    vector = program.problem["x"]
    return TimedProgram(
        program,
        ca.Function("motion", [vector], [guess.motion_s * time]),
        ca.Function("shares", [vector], [_symbol(visits, -1, 1)]),
        ca.Function("poses", [vector], [_symbol(visits, 0, 6)]),
        visits.spans,
    )


def _coefficients(data: NodeData, guess: TimedGuess) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give guess and bounds of the coefficients: those at rest are given, and those of actuators that must not move."""
    c = guess.spline.c
    low, high = (np.tile(bound, (len(c), 1)) for bound in data.actuator_range_m.T)
    given = np.zeros(c.shape, dtype=bool)
    given[:AT_REST] = given[-AT_REST:] = True
    low[given] = high[given] = c[given]
    still = locked(guess.path.machine) & (np.ptp(c, axis=0) < _STILL_M)
    low[:, still] = high[:, still] = c[0, still]
    return c, low, high


def _rate_rows(machine: Machine, mesh: Mesh, motion: Motion) -> list[Row]:
    """Write the control coefficients of q', q'' and q''' relative to their limits at T, within -1 and 1."""
    rows = []
    for limit in rate_limits(machine):
        kept = np.flatnonzero(np.isfinite(limit.largest))
        if len(kept):
            scale = ca.DM(np.diag(1.0 / (limit.largest[kept] * motion.guess_s**limit.order)))
            matrix = sparse(derivative_matrix(mesh.knots, DEGREE, limit.order))
            rates = scale @ motion.x.coefficients[kept.tolist(), :] @ matrix.T
            rows.append(Row(limit.name, ca.vec(rates) / motion.time**limit.order, -1.0, 1.0))
    return rows


def _mean_square_jerk(machine: Machine, mesh: Mesh, x: Symbols, guess: TimedGuess) -> ca.MX:
    """Write the mean square of the control coefficients of jerk at the guess's T, relative to the limits.

    Where there is no limit, to the largest of the guess.
    """
    matrix, limit = derivative_matrix(mesh.knots, DEGREE, 3), rate_limits(machine)[2].largest
    largest = np.abs(matrix @ guess.spline.c).max(axis=0) / guess.motion_s**3
    scale = np.where(np.isfinite(limit), limit, np.where(largest > 0.0, largest, 1.0))
    jerk = ca.DM(np.diag(1.0 / (scale * guess.motion_s**3))) @ x.coefficients @ sparse(matrix).T
    return ca.sumsqr(jerk) / jerk.numel()


def _symbol(visits: VisitPart, number: int, rows: int) -> ca.MX:
    return visits.unknowns[number].symbol if visits.unknowns else ca.MX(rows, 0)
