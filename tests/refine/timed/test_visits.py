"""Poses to visit at times that are unknowns."""

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import BSpline

from pipeline.machine import Machine
from pipeline.refine import Refinement
from pipeline.refine.splines import DEGREE, clamped_knots
from pipeline.refine.timed.visits import VisitNodes, visit_part, visits_at

COUNT = 14


def test_a_visit_is_on_the_splines_at_any_time_of_its_span(machine: Machine, refinement: Refinement) -> None:
    """Its rows vanish where its pose and actuators are those of the splines, and only there."""
    path, tau = refinement.path, np.array([0.21, 0.77])
    spline = BSpline(clamped_knots(COUNT), np.random.default_rng(1).normal(size=(COUNT, 5)), DEGREE)
    symbol = ca.MX.sym("c", 5, COUNT)
    free = np.full((2, 6), np.inf)
    part = visit_part(machine, VisitNodes(tau, path.pose(tau)), (-free, free), spline, symbol)
    _, q, share = part.unknowns
    row = next(row for row in part.rows if row.name == "visits on the motion")
    missed = ca.Function("missed", [q.symbol, share.symbol, symbol], [row.expression])
    assert np.abs(np.array(missed(q.guess.T, share.guess, spline.c.T))).max() < 1e-12
    later = np.array([0.9, 0.1])
    times = part.spans[:, 0] + later * (part.spans[:, 1] - part.spans[:, 0])
    assert np.abs(np.array(missed(spline(times).T, later, spline.c.T))).max() < 1e-12
    assert np.abs(np.array(missed(q.guess.T, later, spline.c.T))).max() > 1e-3


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
    none = np.zeros((0, 6))
    part = visit_part(machine, VisitNodes(np.zeros(0), none), (none, none), spline, ca.MX.sym("c", 5, COUNT))
    assert part.unknowns == ()
    assert part.rows == ()
    assert visits_at(part.spans, np.zeros(0)) == (pytest.approx(np.zeros(0)), False)
