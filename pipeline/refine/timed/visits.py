"""Poses to visit in a motion: each has a node of its own, whose time is an unknown.

On the knot span of its guess q(tau) is a polynomial of degree five, so that the node is on the motion exactly; a visit
that ends at the edge of its span continues in the next one.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.limits.avoid import Box
from pipeline.limits.interface.rows import Row, Unknowns
from pipeline.limits.tilt import node_limits_rad
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import CONTROLLED, RY, TILT_COLUMNS
from pipeline.machine.symbolic import closure_function
from pipeline.refine.splines import DEGREE
from pipeline.route.result import Route

_AT_EDGE = 1e-6
"""Part of a knot span that counts as its edge."""


@dataclass(frozen=True, eq=False)
class VisitNodes:
    """The visits of a motion, v of them, in their order.

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
class VisitPart:
    """What visits add to the program: unknowns and rows, and the knot span of each visit, begin and end (v, 2)."""

    unknowns: tuple[Unknowns, ...]
    rows: tuple[Row, ...]
    spans: FloatArray


def visit_bounds(config: Config, route: Route) -> tuple[FloatArray, FloatArray]:
    """Bound the poses of all visits: given ones are exact, boxes keep the tilt limit. Shapes (v, 6)."""
    low, high = np.full((len(config.task.visit), 6), -np.inf), np.full((len(config.task.visit), 6), np.inf)
    for column, limit in zip(TILT_COLUMNS, node_limits_rad(config), strict=True):
        low[:, column], high[:, column] = -limit, limit
    for row, visit in enumerate(config.task.visit):
        if visit.box is None:
            low[row] = high[row] = route.pose[route.visits == row + 1][0]
            # The links tell the rotation about Y of a pose that is given.
            low[row, RY], high[row, RY] = -np.inf, np.inf
        else:
            box = Box.of(visit.box)
            low[row, CONTROLLED] = np.maximum(low[row, CONTROLLED], box.low)
            high[row, CONTROLLED] = np.minimum(high[row, CONTROLLED], box.high)
    return low, high


def visit_part(
    machine: Machine, visits: VisitNodes, bounds: tuple[FloatArray, FloatArray], spline: BSpline, coefficients: ca.MX
) -> VisitPart:
    """Write that visits are on the splines, within bounds of their poses (v, 6), and that their links close.

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
    free = np.full((count, 5), np.inf)
    guess = (visits.tau - spans[:, 0]) / (spans[:, 1] - spans[:, 0])
    return VisitPart(
        unknowns=(
            Unknowns(pose, np.clip(visits.pose, *bounds), *bounds),
            Unknowns(q, np.asarray(spline(visits.tau), dtype=float), -free, free),
            Unknowns(share, guess, np.zeros(count), np.ones(count)),
        ),
        rows=(
            Row("closure at visits", ca.vec(closure_function(machine).map(count)(pose, q)), 0.0, 0.0),
            Row("visits on the motion", ca.vec(q - ca.horzcat(*on_spline)), 0.0, 0.0),
        ),
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
