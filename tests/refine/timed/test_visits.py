"""Poses to visit at times that are unknowns."""

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import BSpline

from pipeline.machine import Machine
from pipeline.refine import Refinement
from pipeline.refine.splines import DEGREE, clamped_knots
from pipeline.refine.timed.visits import VisitBounds, VisitNodes, visit_part, visits_at

COUNT = 14


def _boxes(count: int) -> VisitBounds:
    free = np.full((count, 6), np.inf)
    return VisitBounds(-free, free, np.full((count, 5), np.nan))


def test_a_visit_is_on_the_splines_at_any_time_of_its_span(machine: Machine, refinement: Refinement) -> None:
    """Its rows vanish where its pose and actuators are those of the splines, and only there."""
    path, tau = refinement.path, np.array([0.21, 0.77])
    spline = BSpline(clamped_knots(COUNT), np.random.default_rng(1).normal(size=(COUNT, 5)), DEGREE)
    symbol = ca.MX.sym("c", 5, COUNT)
    part = visit_part(machine, VisitNodes(tau, path.pose(tau)), _boxes(2), spline, symbol)
    _, q, share = part.unknowns
    row = next(row for row in part.rows if row.name == "visits on the motion")
    missed = ca.Function("missed", [q.symbol, share.symbol, symbol], [row.expression])
    assert np.abs(np.array(missed(q.guess.T, share.guess, spline.c.T))).max() < 1e-12
    later = np.array([0.9, 0.1])
    times = part.spans[:, 0] + later * (part.spans[:, 1] - part.spans[:, 0])
    assert np.abs(np.array(missed(spline(times).T, later, spline.c.T))).max() < 1e-12
    assert np.abs(np.array(missed(q.guess.T, later, spline.c.T))).max() > 1e-3


def test_a_pose_that_is_given_fixes_its_actuators(machine: Machine, refinement: Refinement) -> None:
    """Only the box has closure rows: those of a given pose would have no unknowns."""
    path, tau = refinement.path, np.array([0.21, 0.77])
    pose, q = path.pose(tau), path.q(tau)
    bounds = _boxes(2)
    bounds.low[0] = bounds.high[0] = pose[0]
    bounds.q_m[0] = q[0] + 0.01
    spline = BSpline(clamped_knots(COUNT), np.zeros((COUNT, 5)), DEGREE)
    part = visit_part(machine, VisitNodes(tau, pose), bounds, spline, ca.MX.sym("c", 5, COUNT))
    actuators = part.unknowns[1]
    for side in (actuators.guess, actuators.low, actuators.high):
        np.testing.assert_array_equal(side[0], q[0] + 0.01)
    assert np.isinf(actuators.high[1]).all()
    assert {row.name: row.expression.numel() for row in part.rows} == {
        "visits on the motion": 10,
        "closure at visits": 6,
    }


def test_visits_at_an_edge_go_on_in_the_next_span() -> None:
    """Inside its span a time is kept; at an edge it is carried over, and said to be there."""
    spans = np.array([[0.2, 0.3], [0.5, 0.6]])
    tau, at_edge = visits_at(spans, np.array([0.5, 0.25]))
    np.testing.assert_allclose(tau, [0.25, 0.525])
    assert not at_edge
    tau, at_edge = visits_at(spans, np.array([1.0, 0.0]))
    assert at_edge
    assert tau[0] > 0.3
    assert tau[1] < 0.5


def test_without_visits_there_is_nothing(machine: Machine) -> None:
    """No unknowns and no rows."""
    spline = BSpline(clamped_knots(COUNT), np.zeros((COUNT, 5)), DEGREE)
    none = VisitNodes(np.zeros(0), np.zeros((0, 6)))
    part = visit_part(machine, none, _boxes(0), spline, ca.MX.sym("c", 5, COUNT))
    assert part.unknowns == ()
    assert part.rows == ()
    assert visits_at(part.spans, np.zeros(0)) == (pytest.approx(np.zeros(0)), False)
