"""What machines of an ellipsoid change of the closures is bounded, for any of them and sharply."""

from dataclasses import dataclass

import numpy as np
import pytest
from flint import arb

from pipeline.certify.guess import guess_box
from pipeline.certify.recheck.arithmetic.calibrated import closures as again
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, exactly
from pipeline.certify.recheck.arithmetic.inclusion import build_boxes
from pipeline.certify.recheck.arithmetic.jets import TERMS
from pipeline.certify.recheck.arithmetic.motion import follow
from pipeline.inclusion.calibrated.closures import first_order, link_changes, preconditioned_change, residual_change
from pipeline.inclusion.closure import closure, geometry, working_precision
from pipeline.inclusion.krawczyk import along
from pipeline.inclusion.matrices import ball_matrix, floats
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


@dataclass(frozen=True, eq=False)
class Turned:
    """Bounds of |C dJ|, (6, 6): proven, checked, and the largest that machines and poses have. C is J^-1."""

    proven: np.ndarray
    checked: np.ndarray
    seen: np.ndarray
    by_link: np.ndarray


@pytest.fixture(scope="module")
def turned(line: Path) -> Turned:
    """Take poses up to a millimetre off one of the path, and 3,000 machines."""
    machine, ellipsoid, off = line.machine, some_ellipsoid(3e-4), 1e-3
    pose, q, n = line.pose(0.1), line.q(0.1), 3_000
    u = on_the_sphere(ellipsoid, n)
    poses = pose + np.random.default_rng(2).uniform(-off, off, (n, 6))
    machines, plain = (Machines.at(machine, ellipsoid, part, q) for part in (u, 0.0 * u))
    C, change = np.linalg.inv(plain.jacobian(pose[None])[0]), machines.jacobian(poses) - plain.jacobian(poses)
    with working_precision(64):
        hull = closure(geometry(machine), [arb(x, off) for x in pose.tolist()], [arb(x) for x in q.tolist()])
        proven = preconditioned_change(hull, ball_matrix(C), ellipsoid)
    series = [np.zeros((TERMS, size, 1)) for size in (6, 6, 5)]
    series[0][0, :, 0], series[1][0], series[2][0, :, 0] = pose, off, q
    hull_again = follow(machine, Enclosure(series[0], series[1]), exactly(series[2]))
    return Turned(
        np.array([[float(x.upper()) for x in row] for row in proven]),
        again.preconditioned_change(hull_again, exactly(C[..., None]), ellipsoid)[..., 0],
        np.abs(C @ change).max(axis=0),
        np.abs(C) @ np.abs(change).max(axis=0),
    )


def test_jacobians_change_by_no_more(turned: Turned) -> None:
    """For all machines and poses; what is proven and what is checked are alike, and near what is seen."""
    assert (turned.seen <= turned.proven).all()
    assert (turned.seen <= turned.checked).all()
    assert (turned.seen >= 0.5 * turned.proven).all()
    np.testing.assert_allclose(turned.checked, turned.proven, rtol=1e-3)


def test_links_together_change_less_than_each_by_itself(turned: Turned) -> None:
    """The sum over links of what each changes at most is larger."""
    assert (turned.proven < turned.by_link).mean() > 0.9
