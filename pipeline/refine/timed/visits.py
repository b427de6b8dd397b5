"""Poses to visit in a motion, and approach poses: each has a node of its own, whose time is an unknown.

On the knot span of its guess q(tau) is a polynomial of degree five, so that the node is on the motion exactly; a visit
that ends at the edge of its span continues in the next one.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.limits.avoid import Box
from pipeline.limits.interface.rows import Row, Unknowns
from pipeline.limits.tilt import node_limits_rad
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import CONTROLLED, TILT_COLUMNS
from pipeline.machine.symbolic import closure_function
from pipeline.refine.corridor.cone import straight_ends
from pipeline.refine.result import Path
from pipeline.refine.splines import DEGREE
from pipeline.route.result import Route

_AT_EDGE = 1e-6
"""Part of a knot span that counts as its edge."""


@dataclass(frozen=True, eq=False)
class VisitNodes:
    """The visits and approach poses of a motion, v of them, as `visited_steps` lists them.

    Attributes
    ----------
    tau : (v,)
        When they are.
    pose : (v, 6)
        Their poses.
    """

    tau: FloatArray
    pose: FloatArray


@dataclass(frozen=True, eq=False)
class VisitBounds:
    """Bounds of all visits, v of them.

    Attributes
    ----------
    low, high : (v, 6)
        Bounds of their poses.
    q_m : (v, 5)
        Actuators of the poses that are given, NaN for boxes.
    """

    low: FloatArray
    high: FloatArray
    q_m: FloatArray

    @property
    def boxes(self) -> IntArray:
        """The visits that are boxes."""
        return np.flatnonzero(np.isnan(self.q_m).any(axis=1))


@dataclass(frozen=True, eq=False)
class VisitPart:
    """What visits add to the program: unknowns and rows, and the knot span of each visit, begin and end (v, 2)."""

    unknowns: tuple[Unknowns, ...]
    rows: tuple[Row, ...]
    spans: FloatArray


def visited_steps(config: Config, route: Route, coarse: Path) -> IntArray:
    """List the steps of the route that are visits, in their order, then those that are approach poses. Shape (v,)."""
    visits = [int(np.argmax(route.visits == number)) for number in range(1, len(config.task.visit) + 1)]
    return np.array([*visits, *(end.step for end in straight_ends(config, route, coarse))], dtype=np.int64)


def visit_bounds(config: Config, route: Route, coarse: Path) -> VisitBounds:
    """Bound all visits and approach poses: given poses are those of the route, boxes keep the tilt limit."""
    steps = visited_steps(config, route, coarse)
    low, q_m = route.pose[steps], route.q_m[steps]
    high = low.copy()
    for row, visit in enumerate(config.task.visit):
        if visit.box is not None:
            box, largest = Box.of(visit.box), np.array(node_limits_rad(config))
            low[row], high[row], q_m[row] = -np.inf, np.inf, np.nan
            low[row, list(TILT_COLUMNS)], high[row, list(TILT_COLUMNS)] = -largest, largest
            low[row, CONTROLLED] = np.maximum(low[row, CONTROLLED], box.low)
            high[row, CONTROLLED] = np.minimum(high[row, CONTROLLED], box.high)
    return VisitBounds(low, high, q_m)


def visit_part(
    machine: Machine, visits: VisitNodes, bounds: VisitBounds, spline: BSpline, coefficients: ca.MX
) -> VisitPart:
    """Write that visits are on the splines, within their bounds, and that the links of boxes close.

    The splines have `coefficients` (5, n), guessed as those of `spline`.
    """
    count = len(visits.tau)
    if count == 0:
        return VisitPart((), (), np.zeros((0, 2)))
    edges = np.unique(spline.t)
    first = np.clip(np.searchsorted(edges, visits.tau, side="right") - 1, 0, len(edges) - 2)
    spans = np.column_stack([edges[first], edges[first + 1]])
    pose, q, share = ca.MX.sym("visit_pose", 6, count), ca.MX.sym("visit_q", 5, count), ca.MX.sym("share", 1, count)
    on_spline = [_on_span(spline.t, span, share[k], coefficients) for k, span in enumerate(spans)]
    guess = (visits.tau - spans[:, 0]) / (spans[:, 1] - spans[:, 0])
    guessed_q = np.where(np.isnan(bounds.q_m), spline(visits.tau), bounds.q_m)
    rows = [Row("visits on the motion", ca.vec(q - ca.horzcat(*on_spline)), 0.0, 0.0)]
    # A pose that is given closes, and its unknowns are fixed: a row without unknowns is not wanted.
    if len(boxes := bounds.boxes.tolist()):
        closure = closure_function(machine).map(len(boxes))(pose[:, boxes], q[:, boxes])
        rows.append(Row("closure at visits", ca.vec(closure), 0.0, 0.0))
    return VisitPart(
        unknowns=(
            Unknowns(pose, np.clip(visits.pose, bounds.low, bounds.high), bounds.low, bounds.high),
            Unknowns(q, guessed_q, *(np.where(np.isnan(bounds.q_m), free, bounds.q_m) for free in (-np.inf, np.inf))),
            Unknowns(share, guess, np.zeros(count), np.ones(count)),
        ),
        rows=tuple(rows),
        spans=spans,
    )


def _on_span(knots: FloatArray, span: FloatArray, share: ca.MX, coefficients: ca.MX) -> ca.MX:
    """Write q (5, 1) at a share of a knot span, 0 to 1."""
    begin = int(np.searchsorted(knots, span[0], side="right")) - 1
    shares = np.linspace(0.0, 1.0, DEGREE + 1)
    inside = span[0] + shares * (span[1] - span[0]) * (1.0 - 1e-15)
    values = BSpline.design_matrix(inside, knots, DEGREE).toarray()[:, begin - DEGREE : begin + 1]
    monomials = np.linalg.solve(np.vander(shares, increasing=True), values)
    powers = ca.vertcat(*[share**power for power in range(DEGREE + 1)])
    return coefficients[:, begin - DEGREE : begin + 1] @ (ca.DM(monomials).T @ powers)


def visits_at(spans: FloatArray, shares: FloatArray) -> tuple[FloatArray, bool]:
    """Read the times of visits from their shares (v,) of spans (v, 2), and whether one is at the edge of its span.

    A time at an edge is carried just over it.
    """
    tau = spans[:, 0] + shares * (spans[:, 1] - spans[:, 0])
    below, above = shares < _AT_EDGE, shares > 1.0 - _AT_EDGE
    moved = tau + np.where(above, 1.0, np.where(below, -1.0, 0.0)) * _AT_EDGE * (spans[:, 1] - spans[:, 0])
    return np.asarray(np.clip(moved, 0.0, 1.0)), bool((below | above).any())
