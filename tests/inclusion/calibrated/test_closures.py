"""What machines of an ellipsoid change of the closures is bounded, for any of them and sharply."""

import numpy as np
import pytest
from flint import arb

from pipeline.certify.guess import guess_box
from pipeline.certify.recheck.arithmetic.calibrated import closures as again
from pipeline.certify.recheck.arithmetic.inclusion import build_boxes
from pipeline.inclusion.calibrated.closures import first_order, jacobian_change, link_changes, residual_change
from pipeline.inclusion.closure import closure, geometry, working_precision
from pipeline.inclusion.krawczyk import along
from pipeline.inclusion.matrices import floats
from pipeline.inclusion.pieces import pieces
from pipeline.refine import Path
from tests.certify.possible import Machines, on_the_sphere, some_ellipsoid, towards


@pytest.mark.parametrize("std_m", [1e-4, 2e-3])
def test_residuals_change_by_no_more_and_hardly_less(line: Path, std_m: float) -> None:
    """At poses of the path, and for machines with the largest change of one closure: within 1 % of the bound."""
    machine, piece, ellipsoid = line.machine, pieces(line.spline)[0], some_ellipsoid(std_m)
    box = guess_box(line, piece.first, piece.first + 1e-3)
    assert box is not None
    with working_precision(64):
        balls = geometry(machine)
        series = along(balls, piece, box)
        bounds = np.array([float(e.upper()) for e in residual_change(series.over, ellipsoid)])
        rates = floats(first_order(series.over, link_changes(ellipsoid, [q[0] for q in series.over.q])))
    checked = again.residual_change(build_boxes(machine, line, (box,)).over, ellipsoid)[:, 0]
    u = np.concatenate([on_the_sphere(ellipsoid, 2_000), towards(ellipsoid, rates)])
    s = (box.first + box.last) / 2.0
    pose, q = line.pose(s), line.q(s)
    machines = Machines.at(machine, ellipsoid, u, q)
    plain = Machines.at(machine, ellipsoid, 0.0 * u[:1], q)
    change = np.abs(machines.residuals(np.tile(pose, (len(u), 1))) - plain.residuals(pose[None])).max(axis=0)
    assert (change <= bounds).all()
    assert (change >= 0.98 * bounds).all()
    np.testing.assert_allclose(checked, bounds, rtol=1e-6)


def test_jacobians_change_by_no_more(line: Path) -> None:
    """At poses up to a centimetre off the path; what is proven and what is checked are alike."""
    machine, ellipsoid, piece = line.machine, some_ellipsoid(3e-4), pieces(line.spline)[0]
    s = piece.first
    pose, q, off = line.pose(s), line.q(s), 0.01
    with working_precision(64):
        hull = closure(geometry(machine), [arb(x, off) for x in pose.tolist()], [arb(x) for x in q.tolist()])
        D = np.array([[float(x.upper()) for x in row] for row in jacobian_change(geometry(machine), hull, ellipsoid)])
    u = on_the_sphere(ellipsoid, 3_000)
    poses = pose + np.random.default_rng(2).uniform(-off, off, (len(u), 6))
    machines, plain = (Machines.at(machine, ellipsoid, part, q) for part in (u, 0.0 * u))
    change = np.abs(machines.jacobian(poses) - plain.jacobian(poses)).max(axis=0)
    assert (change <= D).all()
    assert (change >= 0.1 * D).all()
