"""Cones of joints in the nonlinear program: rows that are smooth, and hold where the limit does."""

from collections.abc import Callable

import casadi as ca
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.limits.interface.rows import Nodes, ProgramPart
from pipeline.limits.joint_cone import ConeOfJoint
from pipeline.limits.program_rows.joint_cone import cone_function
from pipeline.machine import Machine
from pipeline.machine.geometry import TELESCOPES, link_lengths
from pipeline.machine.joints.cone import JointCone
from pipeline.machine.kinematics import inverse_kinematics, newton, pose_jacobian
from pipeline.machine.samples import PoseSamples
from tests.joints import cone, every_cone


def _samples(machine: Machine, draw_poses: Callable, seed: int) -> PoseSamples:
    drawn = draw_poses(machine, seed, 60, 40.0)
    return PoseSamples(machine, drawn.pose, drawn.q_m)


def _row_values(samples: PoseSamples, one: JointCone) -> np.ndarray:
    """Compute (cos - least cos) length / usual length by the limit's own values."""
    lengths, usual = link_lengths(samples.machine, samples.q_m[:, 3:]), samples.machine.lengths_m.copy()
    usual[TELESCOPES] = samples.machine.strokes_m.mean(axis=1)
    share = lengths[:, one.link] / usual[one.link]
    return np.asarray(ConeOfJoint(one).values(samples)[:, 0] * share)


def _part(samples: PoseSamples, one: JointCone) -> tuple[ProgramPart, ca.MX, ca.MX]:
    n = len(samples)
    pose, q = ca.MX.sym("pose", 6, n), ca.MX.sym("q", 5, n)
    nodes = Nodes(pose, q, samples, np.zeros((n, 5)), clearance_margin_m=0.001, reach_m=0.05)
    return ConeOfJoint(one).program_part(nodes), pose, q


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=5)
def test_rows_and_their_slopes_are_those_of_the_limit(machine: Machine, draw_poses: Callable, seed: int) -> None:
    """Of all joints, where links close; slopes along every actuator are differences of the limit's own values."""
    samples, h = _samples(machine, draw_poses, seed), 1e-5
    along = pose_jacobian(machine, samples.pose, samples.q_m)
    for one in every_cone(70.0):
        function = cone_function(machine, one)
        pose, q = ca.SX.sym("pose", 6), ca.SX.sym("q", 5)
        value = function(pose, q, one.least_cosine)
        slopes = ca.Function("slopes", [pose, q], [value, ca.jacobian(value, pose), ca.jacobian(value, q)])
        for row in range(min(len(samples), 4)):
            found, by_pose, by_q = (np.array(part) for part in slopes(samples.pose[row], samples.q_m[row]))
            at = samples.take(np.array([row]))
            np.testing.assert_allclose(found[0], _row_values(at, one), atol=1e-12)
            moved = np.concatenate([samples.q_m[row] + sign * h * np.eye(5) for sign in (1.0, -1.0)])
            poses, miss = newton(machine, moved, np.tile(samples.pose[row], (10, 1)))
            assert (miss < 1e-10).all()
            ahead, behind = np.split(_row_values(PoseSamples(machine, poses, moved), one), 2)
            slope = (by_pose @ along[row] + by_q)[0]
            # Differences are good to their third derivative, which is large where the pose changes fast.
            np.testing.assert_allclose(slope, (ahead - behind) / (2.0 * h), rtol=1e-4, atol=1e-4)


def _reachable(machine: Machine, draw_controlled: Callable) -> PoseSamples:
    solution = inverse_kinematics(machine, *draw_controlled(8, 60))
    return PoseSamples(machine, solution.pose, solution.q_m).take(solution.reachable)


def test_all_inner_nodes_keep_the_margin(machine: Machine, draw_controlled: Callable) -> None:
    """Ends that are within the margin have what they have of it, and the rest gets it over the first nodes."""
    drawn, one = _reachable(machine, draw_controlled), cone("2a", "platform", (0.0, 0.99, -0.14), 90.0)
    cosines = ConeOfJoint(one).values(drawn)[:, 0]
    order = np.argsort(cosines)
    samples = drawn.take(np.tile(order, 6))
    edge = float(np.rad2deg(np.arccos(cosines.min())))
    # The first node is at the edge, the last one far from it.
    one = cone("2a", "platform", (0.0, 0.99, -0.14), edge)
    limit = ConeOfJoint(one)
    part, pose, q = _part(samples, one)
    (row,) = part.rows
    assert part.unknowns == ()
    assert (row.low, row.high) == (0.0, np.inf)
    found = np.array(ca.Function("row", [pose, q], [row.expression])(samples.pose.T, samples.q_m.T))[:, 0]
    kept = limit.values(samples)[1:-1, 0] - found
    assert 0.0 < kept[0] < 0.2 * limit.node_margin(0.001)
    assert (np.diff(kept) >= -1e-12).all()
    np.testing.assert_allclose(kept[len(kept) // 5 :], limit.node_margin(0.001), rtol=1e-6)


def test_joints_far_from_their_cones_have_no_rows(machine: Machine, draw_controlled: Callable) -> None:
    """A machine whose joints turn far is planned as without cones."""
    part, _, _ = _part(_reachable(machine, draw_controlled), cone("2a", "platform", (0.0, 0.99, -0.14), 179.0))
    assert part.rows == ()


def test_narrow_cones_keep_half_of_themselves(machine: Machine) -> None:
    """The margin of nodes leaves room in any cone."""
    for half_angle_deg in (0.01, 0.3, 40.0, 179.9):
        limit = ConeOfJoint(cone("1", "cart", (0.0, 0.0, 1.0), half_angle_deg))
        assert 0.0 < limit.node_margin(0.001) < 1.0 - limit.cone.least_cosine
