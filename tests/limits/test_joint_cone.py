"""Cones of joints as limits: against angles by rotation matrices, and in words."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.limits import admits, pose_limits
from pipeline.limits.joint_cone import (
    ALL_CONES,
    MEASURES,
    for_moves,
    for_path,
    for_poses,
    joint_angles_deg,
    relaxations,
)
from pipeline.machine import Machine, build_machine, inverse_kinematics
from pipeline.machine.geometry import ARM_OF_LINK
from pipeline.machine.joints.cone import JointCone
from pipeline.machine.samples import PoseSamples
from pipeline.route import build_regions
from tests.conftest import CONFIGS
from tests.joints import CONES, cone, every_cone, with_cones


@pytest.fixture(scope="module")
def tiny_config() -> Config:
    """Load the reference machine on the coarsest grid."""
    return load_config(CONFIGS / "tiny.yaml")


def draw(machine: Machine, draw_controlled: Callable, seed: int, count: int = 60) -> PoseSamples:
    """Draw reachable poses, whatever their kappa."""
    controlled, modes = draw_controlled(seed, count)
    solution = inverse_kinematics(machine, controlled, modes)
    return PoseSamples(machine, solution.pose, solution.q_m).take(solution.reachable)


def brute_angle_deg(samples: PoseSamples, one: JointCone, row: int) -> float:
    """Turn joints and axis by matrices about one axis after the other, and measure the angle by its tangent."""
    machine, (x, y, z, rx, ry, rz) = samples.machine, samples.pose[row]
    R = (
        Rotation.from_rotvec([rx, 0, 0]) * Rotation.from_rotvec([0, 0, rz]) * Rotation.from_rotvec([0, ry, 0])
    ).as_matrix()
    arm = ARM_OF_LINK[one.link]
    platform = np.array([x, y, z]) + R @ machine.platform_points_m[one.link]
    cart = np.append(samples.q_m[row, arm], machine.rails_m[arm]) + machine.cart_offsets_m[one.link]
    leaving = R.T @ (cart - platform) if one.at_platform else platform - cart
    return float(np.rad2deg(np.arctan2(np.linalg.norm(np.cross(leaving, one.axis)), leaving @ one.axis)))


@given(seed=st.integers(0, 2**32 - 1), half_angle_deg=st.floats(5.0, 175.0))
@settings(max_examples=15)
def test_margins_are_those_of_the_angles(
    machine: Machine, draw_controlled: Callable, seed: int, half_angle_deg: float
) -> None:
    """At all twelve joints: the margin is the difference of cosines, and says whether the angle is within the cone."""
    conical = with_cones(machine, *every_cone(half_angle_deg))
    samples = draw(conical, draw_controlled, seed, 30)
    limits = for_poses(conical, 1.0)
    assert len(limits) == 12
    for limit, one in zip(limits, conical.joint_cones, strict=True):
        angles = np.array([brute_angle_deg(samples, one, row) for row in range(len(samples))])
        margins = np.cos(np.deg2rad(angles)) - np.cos(np.deg2rad(half_angle_deg))
        np.testing.assert_allclose(limit.margins(samples)[:, 0], margins, atol=1e-12)
        np.testing.assert_allclose(limit.excess(samples)[:, 0], angles - half_angle_deg, atol=1e-6)
        clear = np.abs(angles - half_angle_deg) > 1e-6
        np.testing.assert_array_equal(admits(limit, samples)[clear], (angles <= half_angle_deg)[clear])


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=5)
def test_links_along_their_axis_have_a_margin_too(machine: Machine, draw_controlled: Callable, seed: int) -> None:
    """At angles of 0 and 180 degrees, where the angle itself has a kink, and rounding takes cosines beyond one."""
    samples = draw(machine, draw_controlled, seed, 10)
    for row in range(len(samples)):
        along = samples.H[row, :3, 2]
        for sign, angle in ((1.0, 0.0), (-1.0, 180.0)):
            conical = with_cones(machine, cone("2b", "cart", tuple((sign * along).tolist()), 30.0))
            (limit,) = for_poses(conical, 1.0)
            one = samples.take(np.array([row]))
            assert joint_angles_deg(conical.joint_cones[0], one)[0] == pytest.approx(angle, abs=1e-5)
            assert limit.margins(one)[0, 0] == pytest.approx(np.cos(np.deg2rad(angle)) - np.cos(np.deg2rad(30.0)))


@pytest.mark.parametrize("half_angle_deg", [1.0, 60.0, 120.0])
def test_equality_is_admitted(machine: Machine, draw_controlled: Callable, half_angle_deg: float) -> None:
    """A link exactly at the edge of its cone is within it; the nearest number beyond is not."""
    conical = with_cones(machine, cone("3a", "cart", (1.0, 0.0, 0.0), half_angle_deg))
    (limit,), one = for_poses(conical, 1.0), draw(conical, draw_controlled, 2).take(np.array([0]))
    least = conical.joint_cones[0].least_cosine
    for cosine, kept in ((least, True), (np.nextafter(least, -2.0), False)):
        H = one.H.copy()
        H[0, :3, 3] = [cosine, np.sqrt(1.0 - cosine**2), 0.0]
        at_edge = one.with_known(H=H)
        assert admits(limit, at_edge)[0] == kept
        assert bool(limit.violations(at_edge)) == (not kept)


@given(seed=st.integers(0, 2**32 - 1), shift_m=st.floats(-1.0, 1.0))
@settings(max_examples=5)
def test_angles_do_not_depend_on_x(machine: Machine, draw_controlled: Callable, seed: int, shift_m: float) -> None:
    """Moving everything along the rails leaves them as they are."""
    conical = with_cones(machine, *every_cone(60.0))
    samples = draw(conical, draw_controlled, seed, 20)
    moved = PoseSamples(
        conical, samples.pose + shift_m * np.eye(6)[0], samples.q_m + shift_m * np.array([1, 1, 1, 0, 0])
    )
    for limit in for_poses(conical, 1.0):
        np.testing.assert_allclose(limit.margins(moved), limit.margins(samples), atol=1e-12)


def test_regions_are_those_within_the_cones(tiny_config: Config, vary: Callable) -> None:
    """Regions without the limits, less those that break one."""
    config = vary(tiny_config, CONES)
    machine, free = build_machine(config.machine), build_machine(tiny_config.machine)
    every, kept = build_regions(tiny_config, free), build_regions(config, machine)
    samples = every.samples(machine)
    inside = np.all([admits(limit, samples) for limit in for_poses(machine, 1.0)], axis=0)
    assert len(every) / 4 < np.count_nonzero(inside) < 0.9 * len(every)
    np.testing.assert_array_equal(every.take(inside).controlled, kept.controlled)


def test_wider_cones_cut_the_table(tiny_config: Config, vary: Callable) -> None:
    """A degree apart; a generous table cut down is the one that is built with the value; all cones can be removed."""
    config = vary(tiny_config, {**CONES, "machine.links.l2a.platform_cone.half_angle_deg": 80.5})
    machine = build_machine(config.machine)
    removal, *wider = relaxations(config, machine)
    assert (removal.key, removal.removes, removal.part_of) == (ALL_CONES, True, "")
    assert build_machine(removal.change(1.0).machine).joint_cones == ()
    assert [one.key for one in wider] == [f"{key}.half_angle_deg" for key in CONES]
    assert {one.part_of for one in wider} == {ALL_CONES}
    one = wider[0]
    assert one.levels[[0, 1, 2, -1]].tolist() == [80.5, 81.0, 82.0, 179.0]
    wide, built = (
        build_regions(changed, build_machine(changed.machine)) for changed in (one.change(179.0), one.change(95.0))
    )
    _, inside = one.prepare(wide.samples(machine), wide.x_window_m)(95.0)
    assert 0 < len(built) < len(wide)
    np.testing.assert_array_equal(wide.take(inside).controlled, built.controlled)


def test_a_single_cone_is_part_of_nothing(tiny_config: Config, vary: Callable) -> None:
    """Then its key is the one to let give; one that is as wide as it gets cannot."""
    for half_angle_deg, keys in ((60.0, ["machine.links.l1.cart_cone.half_angle_deg"]), (179.5, [])):
        changes = {"machine.links.l1.cart_cone": {"axis": [0.0, 0.0, -1.0], "half_angle_deg": half_angle_deg}}
        config = vary(tiny_config, changes)
        found = [one for one in relaxations(config, build_machine(config.machine)) if len(one.levels) > 1]
        assert [one.key for one in found] == keys
        assert all(one.part_of == "" for one in found)


def test_words_name_joint_angle_and_key(machine: Machine, draw_controlled: Callable) -> None:
    """A pose is told by how much it turns which joint, and what allows less."""
    conical = with_cones(machine, cone("3b", "cart", (0.0, 0.41, 0.91), 40.0))
    samples = draw(conical, draw_controlled, 3)
    (limit,) = for_path(load_config(CONFIGS / "agder.yaml"), conical)
    angles = joint_angles_deg(conical.joint_cones[0], samples)
    (message,) = limit.violations(samples.take(np.array([angles.argmax()])))
    assert message == (
        f"turns the cart joint of link 3b {angles.max():.4g} degrees off its axis; "
        "machine.links.l3b.cart_cone.half_angle_deg allows 40"
    )
    assert limit.violations(samples.take(np.array([angles.argmin()]))) == []
    assert limit.wording.rejected_move == "the cart joint of link 3b leaves its cone"
    assert limit.wording.raise_key == "machine.links.l3b.cart_cone.half_angle_deg"
    (curve,) = limit.curves(samples)
    assert (curve.name, curve.unit, curve.allowed) == ("3b cart joint", "deg", "<= 40")
    np.testing.assert_array_equal(curve.values, angles)


def test_the_room_is_that_of_the_nearest_cone(machine: Machine, draw_controlled: Callable) -> None:
    """Of paths of machines that have cones, and no others."""
    (measure,) = MEASURES
    conical = with_cones(machine, *every_cone(170.0))
    samples = draw(conical, draw_controlled, 1)
    angles = [joint_angles_deg(one, samples).max() for one in conical.joint_cones]
    assert measure.reduce(samples) == pytest.approx(170.0 - max(angles))
    assert measure.applies(conical)
    assert not measure.applies(machine)


def test_without_cones_there_is_no_limit(quick_config: Config, machine: Machine) -> None:
    """Nothing is checked that is not asked for."""
    assert for_poses(machine, 1.0) == for_moves(quick_config, machine) == for_path(quick_config, machine) == []
    assert relaxations(quick_config, machine) == []
    wide = with_cones(machine, *every_cone(170.0))
    assert len(pose_limits(wide, 1.0)) == len(pose_limits(replace(wide, joint_cones=()), 1.0)) + 12
