"""The shortest motion with bounded jerk along a path, as a nonlinear program in the states at breakpoints.

Breakpoints are fixed in s, the seconds between them are free; in between the time law is quartic (`quartic_law`). At
breakpoints the coefficients of all limits are known numbers, so that the program is polynomial; at points checked
within pieces they are linearised in s about the last time law. Everything is scaled to about one.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.retime.constraints import limit_rows, path_speeds
from pipeline.retime.jerk.quartic_law import QuarticLaw, quartic
from pipeline.retime.path_dynamics import PathDynamics, PathDynamicsTable
from pipeline.solvers import Iteration, run_ipopt

_NEAR = 0.6
"""Fraction of a limit in the last time law from which on the limit is in the program."""
_SLOPE_STEP = 1e-6
"""Difference in s for the slopes of coefficients."""
_SHORTEST, _LONGEST = 0.3, 3.0
"""Bounds on a piece's seconds, relative to those of the last time law."""
_HELD = 1e-8
"""Absolute tolerance of constraints, in fractions of limits."""
_MUMPS = {"mumps_permuting_scaling": 0, "mumps_scaling": 0, "mumps_pivot_order": 0}
"""Everything is scaled already, and approximate minimum degree suits blocks along a diagonal: a third less time."""


@dataclass(frozen=True, eq=False)
class Checks:
    """Points within pieces where limits have to hold, too: number of the piece and elapsed part of it. Shapes (p,)."""

    piece: IntArray
    part: FloatArray


@dataclass(frozen=True, eq=False)
class Program:
    """The program: expressions, bounds, a first guess, and what it takes to read a solution."""

    nlp: dict[str, ca.MX]
    guess: FloatArray
    lbx: FloatArray
    ubx: FloatArray
    lbg: FloatArray
    ubg: FloatArray
    before: QuarticLaw
    scale: FloatArray

    def time_law(self, x: ca.DM) -> QuarticLaw:
        """Convert unknowns to a time law."""
        n = len(self.before.s)
        v, w, j, h = np.split(np.asarray(x, dtype=float).ravel(), [n, 2 * n, 3 * n])
        return QuarticLaw(self.before.s, *(part * unit for part, unit in zip((v, w, j, h), self.scale, strict=True)))


def build_program(table: PathDynamicsTable, before: QuarticLaw, checks: Checks) -> Program:
    """Build the program: minimise the sum of h under all limits at breakpoints and checks.

    Speed, acceleration and jerk along the path are zero at both ends, or free where the path itself is at rest there,
    having come with a time law. Limits that the time law `before` keeps by a wide
    margin at a point are left out there.
    """
    n = len(before.s)
    scale = np.array([np.abs(before.v).max(), np.abs(before.w).max(), np.abs(before.j).max(), before.h.mean()])
    # At constant speed there are neither accelerations nor jerks.
    scale = np.where(scale > 0.0, scale, scale[0] ** np.array([1, 2, 3, 0]))
    x = ca.MX.sym("x", 4 * n - 1)
    parts = ca.vertsplit(x, [0, n, 2 * n, 3 * n, 4 * n - 1])
    v, w, j, h = (part * float(unit) for part, unit in zip(parts, scale, strict=True))
    s = ca.DM(before.s)
    s1, v1, w1, _ = quartic(s[:-1], v[:-1], w[:-1], j[:-1], j[1:], h, 1.0)
    joined = [(s1 - s[1:]) / np.diff(before.s), (v1 - v[1:]) / scale[0], (w1 - w[1:]) / scale[1]]
    at_nodes = _fractions(table.at(before.s))
    kept = _near(at_nodes, (before.v, before.w, before.j)).expressions((v, w, j))
    s_check, *known = before.state(checks.piece, checks.part)
    begins, ends = checks.piece.tolist(), (checks.piece + 1).tolist()
    s_new, *state = quartic(s[begins], v[begins], w[begins], j[begins], j[ends], h[begins], ca.DM(checks.part))
    within, beside = (_fractions(table.at(place.clip(0.0, 1.0))) for place in (s_check, s_check + _SLOPE_STEP))
    kept += _near(within, tuple(known), beside).expressions(tuple(state), s_new - ca.DM(s_check))
    held = ca.vertcat(*kept)
    lbx, ubx = _bounds(before, at_nodes, scale, at_rest=table.path.motion_s is None)
    equations = np.zeros(3 * (n - 1))
    return Program(
        nlp={"x": x, "f": ca.sum1(h) / before.h.sum(), "g": ca.vertcat(*joined, held)},
        guess=np.concatenate([part / unit for part, unit in zip(_parts(before), scale, strict=True)]),
        lbx=lbx,
        ubx=ubx,
        lbg=np.concatenate([equations, np.full(held.numel(), -np.inf)]),
        ubg=np.concatenate([equations, np.ones(held.numel())]),
        before=before,
        scale=scale,
    )


def solve_program(
    program: Program, max_iterations: int, verbose: bool = False, listener: Iteration = lambda number, objective: None
) -> tuple[QuarticLaw, str, int]:
    """Solve the program with IPOPT; returns the time law, how the solver ended, and its iterations.

    Raises
    ------
    KeyboardInterrupt
        When the user interrupts.
    """
    ipopt = {
        "print_level": 5 if verbose else 0,
        "nlp_scaling_method": "none",
        "mu_strategy": "adaptive",
        "tol": 1e-7,
        "constr_viol_tol": _HELD,
        "max_iter": max_iterations,
        **_MUMPS,
    }
    given = {"x0": program.guess, "lbx": program.lbx, "ubx": program.ubx, "lbg": program.lbg, "ubg": program.ubg}
    found, stats = run_ipopt("jerk", program.nlp, {"ipopt": ipopt}, given, listener)
    return program.time_law(found["x"]), str(stats["return_status"]), int(stats["iter_count"])


def _parts(law: QuarticLaw) -> tuple[FloatArray, ...]:
    return law.v, law.w, law.j, law.h


def _bounds(
    before: QuarticLaw, at_nodes: "_Fractions", scale: FloatArray, at_rest: bool
) -> tuple[FloatArray, FloatArray]:
    """Bound the scaled unknowns: rest at both ends, velocity limits at breakpoints, seconds near those of before."""
    n = len(before.s)
    with np.errstate(divide="ignore"):
        cap = 1.0 / at_nodes.first[0].max(axis=1)
    free = np.full(n, np.inf)
    if at_rest:
        for part in (cap, free):
            part[[0, -1]] = 0.0
    seconds = before.h / scale[3]
    lower = np.concatenate([np.zeros(n), -free, -free, _SHORTEST * seconds])
    return lower, np.concatenate([cap / scale[0], free, free, _LONGEST * seconds])


_State = tuple[Any, Any, Any]
"""sd, sdd, sddd at points, as numbers (n,) or as expressions."""


@dataclass(frozen=True, eq=False)
class _Fractions:
    """Coefficients (n, m) of fractions of limits at n points, which must not exceed one.

    Those of first order multiply sd, of second order sdd, sd^2 and 1, of third order sddd, 3 sd sdd and sd^3.
    """

    first: tuple[FloatArray, ...]
    second: tuple[FloatArray, ...]
    third: tuple[FloatArray, ...]

    @property
    def orders(self) -> tuple[tuple[FloatArray, ...], ...]:
        return self.first, self.second, self.third


def _monomials(state: _State) -> tuple[tuple[Any, ...], ...]:
    """Compute what the coefficients of `_Fractions` multiply."""
    v, w, j = state
    return (v,), (w, v**2, 1.0 + 0.0 * v), (j, 3.0 * v * w, v**3)


def _fractions(dynamics: PathDynamics) -> _Fractions:
    """Compute the coefficients of all limits at points of a path; zero where there is no limit."""
    rows, (speeds, allowed) = limit_rows(dynamics), path_speeds(dynamics)
    jerks = (part / dynamics.machine.jerk_mps3 for part in (dynamics.q1, dynamics.q2, dynamics.q3))
    return _Fractions(
        (speeds / allowed,),
        (rows.a, rows.b, rows.c),
        tuple(np.concatenate([part, -part], axis=1) for part in jerks),
    )


@dataclass(frozen=True, eq=False)
class _Near:
    """The fractions that matter, by order: their points, their coefficients, and the slopes of these in s."""

    points: list[IntArray]
    coefficients: list[list[FloatArray]]
    slopes: list[list[FloatArray]]

    def expressions(self, state: _State, moved: ca.MX | None = None) -> list[ca.MX]:
        """Write the fractions for a state (n,), at points that have moved in s by `moved` (n,)."""
        expressions = []
        for points, coefficients, slopes, monomials in zip(
            self.points, self.coefficients, self.slopes, _monomials(state), strict=True
        ):
            where, fraction = points.tolist(), ca.MX(0.0)
            for coefficient, slope, monomial in zip(coefficients, slopes, monomials, strict=True):
                factor = ca.DM(coefficient) if moved is None else ca.DM(coefficient) + ca.DM(slope) * moved[where]
                fraction = fraction + factor * monomial[where]
            if where:
                expressions.append(fraction)
        return expressions


def _near(here: _Fractions, before: _State, beside: _Fractions | None = None) -> _Near:
    """Select the fractions that were near one in the last state."""
    near = _Near([], [], [])
    others = here.orders if beside is None else beside.orders
    for order, other, monomials in zip(here.orders, others, _monomials(before), strict=True):
        fraction = sum(part * number[:, None] for part, number in zip(order, monomials, strict=True))
        # Path jerks may change freely from one breakpoint to the next, whatever they were before.
        point, row = np.nonzero(fraction > (-np.inf if beside is None and order is here.third else _NEAR))
        near.points.append(point)
        near.coefficients.append([part[point, row] for part in order])
        near.slopes.append([(b[point, row] - a[point, row]) / _SLOPE_STEP for a, b in zip(order, other, strict=True)])
    return near
