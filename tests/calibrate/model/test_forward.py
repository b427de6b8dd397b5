"""What a tracker sees, and its derivatives."""

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.arrays import FloatArray
from pipeline.calibrate.model.forward import close, pose_rates, position_jacobian, positions
from pipeline.calibrate.model.model import Model
from pipeline.machine import Machine, forward_kinematics
from pipeline.machine.geometry import ARM_OF_LINK
from tests.calibrate.conftest import Seen


@pytest.fixture(scope="module")
def seen(see: Callable[..., Seen]) -> Seen:
    """Measure three reflectors of a machine whose rails are not parallel."""
    return see(3, poses=12, direction_std_rad=2e-4, geometry_std_m=5e-4, seed=3)


def test_the_configured_machine_is_the_one_that_is_planned_for(seen: Seen, machine: Machine):
    """Without deviations poses are those of forward kinematics, and reflectors where these put them."""
    q = seen.simulated.poses.q_m
    closed = close(seen.configured, q, seen.guess)
    assert closed.miss_m.max() < 1e-12
    np.testing.assert_allclose(closed.pose, forward_kinematics(machine, q, seen.guess), rtol=0.0, atol=1e-11)
    R = Rotation.from_euler("XZY", closed.pose[:, [3, 5, 4]]).as_matrix()
    expected = closed.pose[:, None, :3] + seen.configured.reflectors_m @ np.swapaxes(R, 1, 2)
    np.testing.assert_allclose(positions(seen.configured, closed), expected, atol=1e-14)


def test_derivatives_are_those_of_differences(seen: Seen):
    """All columns agree with central differences of the whole model, assembled anew."""
    model, q = seen.simulated.truth, seen.simulated.poses.q_m
    closed = close(model, q, seen.guess)
    J, step = position_jacobian(model, q, closed), 1e-5
    found = np.zeros_like(J)
    for k in range(J.shape[-1]):
        change = np.zeros(J.shape[-1])
        change[k] = step
        there, back = (model.moved(sign * change) for sign in (1.0, -1.0))
        ahead, behind = (positions(one, close(one, q, closed.pose)) for one in (there, back))
        found[..., k] = (ahead - behind) / (2.0 * step)
    np.testing.assert_allclose(J, found, rtol=0.0, atol=1e-6 * np.abs(J).max())


def _casadi_positions(model: Model, q: FloatArray, pose: FloatArray, theta: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Write one pose in formulas of its own: symbols of the pose, misses of links, positions of reflectors."""
    parts = ca.vertsplit(theta, np.cumsum([0, 18, 18, 6, 4, 5, 5, 6, 3 * len(model.reflectors_m), 6]).tolist())
    platform, offsets, rails, lengths, zeros, scales, slopes, places, tracker = parts
    x = ca.SX.sym("pose", 6)
    rx, ry, rz = x[3], x[4], x[5]

    def turn(axis: int, angle: ca.SX) -> ca.SX:
        i, j = [k for k in range(3) if k != axis]
        R = ca.SX.eye(3)
        R[i, i] = R[j, j] = ca.cos(angle)
        sign = -1.0 if axis == 1 else 1.0
        R[i, j], R[j, i] = -sign * ca.sin(angle), sign * ca.sin(angle)
        return R

    R = turn(0, rx) @ turn(2, rz) @ turn(1, ry)
    actual = model.middles_m + model.zeros_m + zeros + (model.scales + scales) * (q - model.middles_m)
    fixed, misses = {0: 0, 1: 1, 3: 2, 5: 3}, []
    for link, arm in enumerate(ARM_OF_LINK.tolist()):
        point = x[:3] + R @ (model.platform_points_m[link] + platform[3 * link : 3 * link + 3])
        along = actual[arm] - model.middles_m[arm]
        rise = (model.directions_rad[arm] + slopes[2 * arm : 2 * arm + 2]) * along
        rail = ca.vertcat(actual[arm], model.rails_m[arm] + rails[2 * arm : 2 * arm + 2] + rise)
        joint = rail + model.cart_offsets_m[link] + offsets[3 * link : 3 * link + 3]
        length = model.lengths_m[link] + lengths[fixed[link]] if link in fixed else actual[3 if link == 2 else 4]
        misses.append(ca.norm_2(point - joint) - length)
    w = tracker[:3]
    Q = (ca.SX.eye(3) + ca.skew(w)) @ model.rotation
    seen = [
        Q @ (x[:3] + R @ (place + places[3 * k : 3 * k + 3])) + model.translation_m + tracker[3:]
        for k, place in enumerate(model.reflectors_m)
    ]
    return x, ca.vertcat(*misses), ca.vertcat(*seen)


def test_derivatives_are_those_of_casadi(seen: Seen):
    """Formulas of their own, differentiated by CasADi through the closures, give the same columns to rounding."""
    model, q = seen.simulated.truth, seen.simulated.poses.q_m
    closed = close(model, q, seen.guess)
    J = position_jacobian(model, q, closed)
    theta = ca.SX.sym("theta", model.parameters.count)
    for row in (0, 5, 11):
        x, misses, where = _casadi_positions(model, q[row], closed.pose[row], theta)
        by_pose, by_theta = (ca.Function("f", [x, theta], [ca.jacobian(misses, v)]) for v in (x, theta))
        direct, through = (ca.Function("f", [x, theta], [ca.jacobian(where, v)]) for v in (theta, x))
        at = (closed.pose[row], np.zeros(theta.numel()))
        pose_by_theta = -np.linalg.solve(np.array(by_pose(*at)), np.array(by_theta(*at)))
        expected = np.array(direct(*at)) + np.array(through(*at)) @ pose_by_theta
        np.testing.assert_allclose(J[row].reshape(-1, J.shape[-1]), expected, rtol=0.0, atol=1e-11 * np.abs(J).max())


def test_a_zero_is_a_step_of_its_encoder(seen: Seen):
    """Moving a cart's zero and moving the cart are one thing where its scale is one."""
    model, q = replace(seen.configured), seen.simulated.poses.q_m
    closed = close(model, q, seen.guess)
    moved, _ = pose_rates(model, q, closed)
    zero = model.parameters.names.index("zero c2")
    step = np.array([0.0, 1e-6, 0.0, 0.0, 0.0])
    ahead, behind = (close(model, q + sign * step, seen.guess).pose[:, :3] for sign in (1.0, -1.0))
    np.testing.assert_allclose(moved[:, :, zero], (ahead - behind) / 2e-6, rtol=0.0, atol=1e-5)
