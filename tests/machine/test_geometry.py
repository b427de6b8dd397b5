"""Frames, joints and links as arrays."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pipeline.config import Config, MachineConfig
from pipeline.machine.geometry import (
    MODE_SIGNS,
    MODES,
    Machine,
    build_machine,
    cart_joints,
    cross,
    dot,
    link_lengths,
    link_vectors,
    platform_arms,
    rotation,
    rotation_x,
    rotation_z,
    turned,
)

angles = st.floats(-4.0, 4.0)


@given(angles, angles, angles)
def test_rotation_turns_about_y_then_z_then_x(rx, ry, rz):
    """R = Rx(rx) Rz(rz) Ry(ry), as scipy composes it."""
    expected = Rotation.from_euler("XZY", [rx, rz, ry]).as_matrix()
    np.testing.assert_allclose(rotation(np.array(rx), np.array(ry), np.array(rz)), expected, atol=1e-14)


@given(angles)
def test_elementary_rotations_turn_about_their_axis(angle):
    """Rx and Rz agree with scipy's rotation vectors."""
    np.testing.assert_allclose(rotation_x(angle), Rotation.from_rotvec([angle, 0, 0]).as_matrix(), atol=1e-14)
    np.testing.assert_allclose(rotation_z(angle), Rotation.from_rotvec([0, 0, angle]).as_matrix(), atol=1e-14)


def test_rotation_broadcasts_over_leading_axes():
    """Angles of shape (2, 3) give matrices of shape (2, 3, 3, 3)."""
    rx = np.linspace(-1.0, 1.0, 6).reshape(2, 3)
    R = rotation(rx, np.zeros((2, 3)), np.zeros((2, 3)))
    assert R.shape == (2, 3, 3, 3)
    np.testing.assert_allclose(R[1, 2], rotation_x(rx[1, 2]), atol=1e-15)


def test_modes_are_counted_with_arm_1_as_the_highest_bit():
    """LLL is 0, LLR is 1, RLL is 4, RRR is 7; an R is a cart at larger x."""
    assert [MODES.index(mode) for mode in ("LLL", "LLR", "LRL", "RLL", "RRR")] == [0, 1, 2, 4, 7]
    for number, mode in enumerate(MODES):
        bits = [number >> 2 & 1, number >> 1 & 1, number & 1]
        assert [letter == "R" for letter in mode] == bits
        np.testing.assert_array_equal(MODE_SIGNS[number], np.where(bits, 1.0, -1.0))


def test_reference_machine_has_the_published_numbers(machine: Machine):
    """Rails, lengths and strokes are those of the configuration, telescopes have no length of their own."""
    np.testing.assert_array_equal(machine.rails_m, [[0.0, 1.5], [0.75, 1.5], [0.0, 0.0]])
    np.testing.assert_allclose(
        machine.lengths_m, [1.09, 1.09, np.nan, 1.25, np.nan, np.sqrt(1.25**2 + 0.13**2)], rtol=1e-15
    )
    np.testing.assert_array_equal(
        machine.actuator_limits_m, [[0.0, 2.1], [0.0, 2.1], [0.0, 2.1], [0.95, 1.25], [1.05, 1.4]]
    )
    np.testing.assert_array_equal(machine.velocity_mps, [0.5, 0.5, 0.5, 0.1, 0.1])
    np.testing.assert_array_equal(machine.acceleration_mps2, [2.0, 2.0, 2.0, 0.5, 0.5])
    assert machine.triangle_sign == -1.0
    assert np.isnan(machine.link_rail_m)


def test_options_of_the_configuration_reach_the_machine(agder_config: Config):
    """A length for 3c, the other branch and a distance to the rails are taken over."""
    data = agder_config.machine.model_dump()
    data["links"]["l3c"]["length_m"] = 1.2
    data["triangle_branch"] = "positive"
    data["clearance"]["link_rail_m"] = 0.05
    machine = build_machine(MachineConfig.model_validate(data))
    assert machine.lengths_m[5] == 1.2
    assert machine.triangle_sign == 1.0
    assert machine.link_rail_m == 0.05


def test_joints_at_the_untilted_pose_are_sums_of_offsets(machine: Machine):
    """With R = 1 platform joints are p + a_l, and cart joints sit on their rails beside the cart."""
    pose = np.array([1.0, 0.2, 0.8, 0.0, 0.0, 0.0])
    carts = np.array([0.1, 0.2, 0.3])
    np.testing.assert_array_equal(platform_arms(machine, pose), machine.platform_points_m)
    joints = cart_joints(machine, carts)
    np.testing.assert_allclose(joints[0], [0.1, 0.0, 1.5])
    np.testing.assert_allclose(joints[2], [0.2, 0.75 + 0.28, 1.5])
    np.testing.assert_allclose(joints[4], [0.3, 0.28, 0.0])
    expected = pose[:3] + machine.platform_points_m - joints
    np.testing.assert_allclose(link_vectors(machine, pose, carts), expected)


def test_joints_of_many_poses_are_those_of_each(machine: Machine):
    """Leading axes are carried through, and the machine's own arrays stay as they are."""
    rng = np.random.default_rng(0)
    pose, carts = rng.normal(size=(2, 4, 6)), rng.normal(size=(2, 4, 3))
    many = link_vectors(machine, pose, carts)
    assert many.shape == (2, 4, 6, 3)
    np.testing.assert_allclose(many[1, 2], link_vectors(machine, pose[1, 2], carts[1, 2]), atol=1e-15)
    np.testing.assert_array_equal(machine.cart_offsets_m[0], 0.0)


def test_products_of_vectors_are_numpys():
    """Whatever the leading axes are, and however the arrays are stored."""
    a, b = np.random.default_rng(0).normal(size=(2, 4, 5, 3))
    R = rotation(*a[0].T)
    for left, right in ((a, b), (np.moveaxis(np.moveaxis(a, -1, 0).copy(), 0, -1), b), (a[0, 0], b[0, 0])):
        np.testing.assert_allclose(cross(left, right), np.cross(left, right), atol=1e-15)
        np.testing.assert_allclose(dot(left, right), np.sum(left * right, axis=-1), atol=1e-14)
    np.testing.assert_allclose(turned(R, b[0, 0]), R @ b[0, 0], atol=1e-15)


def test_telescope_lengths_take_their_places(machine: Machine):
    """Links 2b and 3b have the given lengths, all others their own."""
    lengths = link_lengths(machine, np.array([[1.0, 1.2], [1.1, 1.3]]))
    np.testing.assert_array_equal(lengths[:, [2, 4]], [[1.0, 1.2], [1.1, 1.3]])
    np.testing.assert_array_equal(lengths[0, [0, 1, 3, 5]], machine.lengths_m[[0, 1, 3, 5]])


def test_the_machine_cannot_be_changed(machine: Machine):
    """Machines are frozen."""
    with pytest.raises(AttributeError):
        machine.link_link_m = 0.0
