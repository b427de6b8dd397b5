"""A single box: what it proves is true, and what is not true it does not prove."""

from dataclasses import replace

import numpy as np
import pytest
from flint import arb

from pipeline.certify.guess import guess_box
from pipeline.inclusion.closure import Geometry, closure, geometry, pose_series, second_derivatives, working_precision
from pipeline.inclusion.krawczyk import Box, Inclusion, along, include
from pipeline.inclusion.pieces import pieces
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty
from pipeline.machine import Machine
from pipeline.machine.kinematics import closure_jacobian, newton
from pipeline.machine.statics import statics_matrix
from pipeline.refine import Path
from tests.certify.audit import ROUNDING, cubic, deviations, samples_in


@pytest.fixture(scope="module")
def balls(machine: Machine) -> Geometry:
    """Turn the machine into balls."""
    return geometry(machine)


def prove(balls: Geometry, path: Path, box: Box, uncertainty: Uncertainty = CERTAIN) -> Inclusion | None:
    """Prove a box of a path on the piece that it is on."""
    (piece,) = (part for part in pieces(path.spline) if part.first <= box.first and box.last <= part.last)
    with working_precision(64):
        return include(balls, along(balls, piece, box), box, uncertainty)


def first_box(path: Path) -> Box:
    """Guess a box over the first piece."""
    piece = pieces(path.spline)[0]
    box = guess_box(path, piece.first, piece.last)
    assert box is not None
    return box


def test_the_image_holds_every_pose(balls: Geometry, line: Path) -> None:
    """Poses by Newton's method are no farther from the cubic than is proven."""
    inclusion = prove(balls, line, first_box(line))
    assert inclusion is not None
    image = np.array([float(k.upper()) for k in inclusion.image])
    assert (image < inclusion.box.radius).all()
    assert (deviations(line, inclusion.box) <= image + ROUNDING).all()


@pytest.mark.parametrize("length_only", [True, False])
def test_an_uncertain_box_holds_the_poses_of_wrong_machines(
    balls: Geometry, machine: Machine, line: Path, length_only: bool
) -> None:
    """For any errors of the machine of up to eps, its pose is within |C| E + k of the cubic."""
    eps = 2e-4
    inclusion = prove(balls, line, first_box(line), Uncertainty(eps, 0.0 if length_only else eps))
    assert inclusion is not None
    C = np.abs(inclusion.inverse[0]) + np.abs(inclusion.inverse[1]) * (inclusion.box.last - inclusion.box.first) / 2.0
    reach = C @ [float(e.upper()) for e in inclusion.residual_change] + [float(k.upper()) for k in inclusion.image]
    random, s = np.random.default_rng(1), samples_in(inclusion.box)
    for _ in range(20):
        joints = [random.choice([-eps, eps], (6, 3)) * (not length_only) for _ in range(2)]
        lengths = random.choice([-eps, eps], 6)
        wrong = replace(
            machine,
            platform_points_m=machine.platform_points_m + joints[0],
            cart_offsets_m=machine.cart_offsets_m + joints[1],
            rails_m=machine.rails_m + random.choice([-eps, eps], (3, 2)) * (not length_only),
            lengths_m=machine.lengths_m + lengths,
        )
        q = line.q(s) + np.concatenate([np.zeros(3), lengths[[2, 4]]])
        pose, miss = newton(wrong, q, line.pose(s))
        assert (miss < ROUNDING).all()
        assert (np.abs(pose - cubic(inclusion.box, s)) <= reach).all()


def test_a_box_in_the_wrong_place_is_not_proven(balls: Geometry, line: Path) -> None:
    """A box beside the solution holds none, and one that does not follow it loses it."""
    box = first_box(line)
    with working_precision(64):
        piece = pieces(line.spline)[0]
        beside = replace(box, pose=box.pose + np.vstack([np.full((1, 6), 0.02), np.zeros((3, 6))]))
        assert include(balls, along(balls, piece, beside), beside, attempts=1) is None
        still = replace(box, pose=np.vstack([cubic(box, np.array([(box.first + box.last) / 2.0])), np.zeros((3, 6))]))
        assert include(balls, along(balls, piece, still), still, attempts=1) is None


def test_series_are_the_functions_of_the_machine(balls: Geometry, machine: Machine, line: Path) -> None:
    """Jacobian and statics matrix agree with those in floats, and second derivatives with differences."""
    pose, q = line.pose(np.array([0.3]))[0], line.q(0.3)
    with working_precision(64):
        series = closure(balls, pose_series(pose[None], arb(0)), pose_series(q[None], arb(0)))
        lengths = np.array([float(length[0].mid()) for length in series.lengths])
        J = np.array([[float(entry[0].mid()) for entry in row] for row in series.jacobian()])
        H = np.array([[float(entry[0].mid()) for entry in row] for row in series.statics()]).T
        np.testing.assert_allclose(J / lengths[:, None], closure_jacobian(machine, pose, q), atol=1e-12)
        np.testing.assert_allclose(H, statics_matrix(machine, pose, q[:3]), atol=1e-12)
        plain = closure(balls, [arb(x) for x in pose.tolist()], [arb(x) for x in q.tolist()])
        hessians = np.array([[float(x.mid()) for x in table] for table in second_derivatives(plain)])
        for k in range(6):
            sides = [pose + side * 1e-5 * np.eye(6)[k] for side in (-1.0, 1.0)]
            J0, J1 = (
                np.array(
                    [
                        [float(x.mid()) for x in row]
                        for row in closure(balls, [arb(v) for v in p.tolist()], plain.q).jacobian()
                    ]
                )
                for p in sides
            )
            np.testing.assert_allclose(hessians.reshape(6, 6, 6)[:, :, k], (J1 - J0) / 2e-5, atol=1e-8)
