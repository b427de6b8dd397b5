"""Rails off X: against a turned machine, differences, CasADi and brute force; parallel rails as the limit."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.machine import (
    Machine,
    build_machine,
    condition_number,
    forward_kinematics,
    inverse_kinematics,
    link_distances,
    link_rail_distances,
    statics_matrix,
)
from pipeline.machine.actuator_space import (
    actuator_rates,
    gravity_forces,
    gravity_stiffness,
    mass_matrix,
    velocity_forces,
)
from pipeline.machine.actuator_space.symbolic import equations_function, stiffness_function
from pipeline.machine.clearance import rail_pairs
from pipeline.machine.dynamics import holding_forces, inverse_dynamics
from pipeline.machine.geometry import rotation
from pipeline.machine.kinematics import closure_residual, discriminants, pose_jacobian
from pipeline.machine.pose import CONTROLLED
from pipeline.machine.rails import rail_points, with_parallel_rails
from pipeline.machine.symbolic import holding_function, joints_function, statics_function
from pipeline.machine.working_modes import reach_along_rails, working_modes
from tests.rails import off_x

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(["on axis", "off axis", "general"])


def _turned(machine: Machine, T: FloatArray) -> tuple[Machine, FloatArray]:
    """Turn all of a machine with parallel rails by T (3, 3), and give by how much its carts' positions change (3,)."""
    along = T[:, 0]
    origins = np.column_stack([np.zeros(3), machine.rails_m]) @ T.T
    # Rails begin where x is 0: carts are as much farther on.
    shift = origins[:, 0] / along[0]
    masses = machine.known_masses
    turned = replace(
        machine,
        rails_m=(origins - shift[:, None] * along)[:, 1:],
        rail_directions=np.tile(along, (3, 1)),
        cart_offsets_m=machine.cart_offsets_m @ T.T,
        masses=replace(masses, gravity_mps2=T @ masses.gravity_mps2),
    )
    return turned, shift


def _angles(R: FloatArray) -> FloatArray:
    """Find rx, ry, rz of R = Rx Rz Ry, (n, 3, 3). Shape (n, 3)."""
    return np.column_stack(
        [np.arctan2(R[:, 2, 1], R[:, 1, 1]), np.arctan2(R[:, 0, 2], R[:, 0, 0]), -np.arcsin(R[:, 0, 1])]
    )


@given(seed=seeds, kind=kinds)
@settings(max_examples=8)
def test_a_machine_turned_with_all_its_rails_does_the_same(
    draw_machine: Callable, draw_poses: Callable, seed: int, kind: str
):
    """A small turn of everything, gravity too, changes neither carts, modes, kappa, distances nor forces."""
    machine = draw_machine(seed, kind)
    sample = draw_poses(machine, seed, 60)
    T = Rotation.from_rotvec(np.random.default_rng(seed).uniform(-0.1, 0.1, 3)).as_matrix()
    turned, shift = _turned(machine, T)
    R = T @ rotation(*sample.pose[:, 3:].T)
    pose = np.column_stack([sample.pose[:, :3] @ T.T, _angles(R)])
    found = inverse_kinematics(turned, pose[:, CONTROLLED], sample.modes)
    np.testing.assert_allclose(found.pose, pose, atol=1e-8)
    np.testing.assert_allclose(found.q_m[:, :3] - shift, sample.q_m[:, :3], atol=1e-8)
    np.testing.assert_allclose(found.q_m[:, 3:], sample.q_m[:, 3:], atol=1e-8)
    np.testing.assert_allclose(found.discriminants_m2, discriminants(machine, sample.pose), atol=1e-8)
    there = (sample.pose, sample.q_m[:, :3]), (found.pose, found.q_m[:, :3])
    H, H_turned = statics_matrix(machine, *there[0]), statics_matrix(turned, *there[1])
    np.testing.assert_allclose(condition_number(H_turned), condition_number(H), rtol=1e-6)
    for distances in (link_distances, link_rail_distances):
        np.testing.assert_allclose(distances(turned, *there[1]), distances(machine, *there[0]), atol=1e-8)
    np.testing.assert_allclose(reach_along_rails(turned, *there[1]), reach_along_rails(machine, *there[0]), atol=1e-8)
    held, turned_held = (
        holding_forces(one, one.known_masses, pose_, H_)
        for one, pose_, H_ in ((machine, sample.pose, H), (turned, found.pose, H_turned))
    )
    np.testing.assert_allclose(turned_held.link_n, held.link_n, rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(turned_held.drive_n, held.drive_n, rtol=1e-5, atol=1e-4)
    carts = actuator_rates(machine, *there[0]), actuator_rates(turned, *there[1])
    speed, speed_turned = (np.linalg.norm(rates.tips, axis=2) for rates in carts)
    np.testing.assert_allclose(speed_turned, speed, rtol=1e-5, atol=1e-5)


@given(seed=seeds, kind=kinds)
@settings(max_examples=8)
def test_both_kinematics_agree_whatever_the_rails(draw_machine: Callable, draw_poses: Callable, seed: int, kind: str):
    """Carts are on their rails and links closed in the mode that was asked for; forward kinematics leads back."""
    machine = off_x(draw_machine(seed, kind), seed)
    sample = draw_poses(machine, seed, 60)
    assert np.abs(closure_residual(machine, sample.pose, sample.q_m)).max() < 1e-10
    away = np.abs(reach_along_rails(machine, sample.pose, sample.q_m[:, :3])).min(axis=1) > 1e-3
    signs = working_modes(reach_along_rails(machine, sample.pose, sample.q_m[:, :3])[away])
    bits = (signs > 0.0) @ [4, 2, 1]
    np.testing.assert_array_equal(bits, sample.modes[away])
    found = forward_kinematics(machine, sample.q_m, sample.pose + 1e-4)
    np.testing.assert_allclose(found, sample.pose, atol=1e-6)


@given(seed=seeds, kind=kinds)
@settings(max_examples=6)
def test_rates_and_forces_are_differences(draw_machine: Callable, draw_poses: Callable, seed: int, kind: str):
    """The pose moves by its Jacobian; holding forces are the slope of the potential energy, carts' too."""
    machine = off_x(draw_machine(seed, kind), seed)
    sample, h = draw_poses(machine, seed, 40, 30.0), 1e-6
    masses = machine.known_masses
    J = pose_jacobian(machine, sample.pose, sample.q_m)
    forces = gravity_forces(machine, actuator_rates(machine, sample.pose, sample.q_m[:, :3]))
    held = holding_forces(machine, masses, sample.pose, statics_matrix(machine, sample.pose, sample.q_m[:, :3]))
    np.testing.assert_allclose(forces, held.drive_n, rtol=1e-8, atol=1e-6)
    for k in range(5):
        moved = [sample.q_m + sign * h * np.eye(5)[k] for sign in (-1.0, 1.0)]
        before, after = (forward_kinematics(machine, q, sample.pose) for q in moved)
        np.testing.assert_allclose(J[:, :, k], (after - before) / (2.0 * h), rtol=1e-4, atol=1e-4)
        energy = [_potential(machine, pose, q) for pose, q in ((before, moved[0]), (after, moved[1]))]
        np.testing.assert_allclose(forces[:, k], (energy[1] - energy[0]) / (2.0 * h), rtol=1e-4, atol=0.05)


def _potential(machine: Machine, pose: FloatArray, q_m: FloatArray) -> FloatArray:
    """Add up -m g . r of everything that has a mass, links half at either end. Shape (n,)."""
    masses, feet = machine.known_masses, rail_points(machine, q_m[:, :3])
    R = rotation(*pose[:, 3:].T)
    joints = pose[:, None, :3] + machine.platform_points_m @ np.swapaxes(R, 1, 2)
    parts = [
        masses.platform_kg * (pose[:, :3] + R @ masses.platform_centre_m),
        masses.load_kg * pose[:, :3],
        np.einsum("l,nlc->nc", masses.link_kg / 2.0, joints),
        masses.cart_kg * feet.sum(axis=1),
        np.einsum("l,nlc->nc", masses.link_kg / 2.0, feet[:, [0, 1, 1, 2, 2, 2]]),
    ]
    return -sum(parts) @ masses.gravity_mps2


@given(seed=seeds)
@settings(max_examples=4)
def test_casadi_has_the_same_machine(draw_machine: Callable, draw_poses: Callable, seed: int):
    """Joints, H, holding forces and the five equations are those in closed form."""
    machine = off_x(draw_machine(seed, "general"), seed)
    sample = draw_poses(machine, seed, 30, 50.0)
    joints, statics, holding = (build(machine) for build in (joints_function, statics_function, holding_function))
    equations, stiffness, masses = equations_function(machine), stiffness_function(machine), machine.known_masses
    for pose, q in zip(sample.pose[:4], sample.q_m[:4], strict=True):
        H = statics_matrix(machine, pose, q[:3])
        np.testing.assert_allclose(np.array(statics(pose, q)), H, atol=1e-12)
        A, C = (np.array(part) for part in joints(pose, q))
        lengths = np.array(machine.lengths_m)
        lengths[[2, 4]] = q[3:]
        np.testing.assert_allclose(np.linalg.norm(A - C, axis=1), lengths, atol=1e-9)
        held = holding_forces(machine, masses, pose[None], H[None])
        residual, drives = (np.array(part).ravel() for part in holding(pose, q, held.link_n[0]))
        np.testing.assert_allclose(residual, 0.0, atol=1e-8)
        np.testing.assert_allclose(drives, held.drive_n[0], atol=1e-8)
        qd = np.linspace(-0.1, 0.2, 5)
        M, c, g, by_q = (np.array(part) for part in equations(pose, q, qd))
        rates = actuator_rates(machine, pose[None], q[None, :3])
        np.testing.assert_allclose(M, mass_matrix(machine, rates)[0], rtol=1e-7, atol=1e-7)
        np.testing.assert_allclose(c.ravel(), velocity_forces(machine, rates, qd[None])[0], rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(g.ravel(), held.drive_n[0], rtol=1e-7, atol=1e-6)
        np.testing.assert_allclose(by_q, pose_jacobian(machine, pose[None], q[None])[0], rtol=1e-7, atol=1e-7)
        K = gravity_stiffness(machine, rates)[0]
        np.testing.assert_allclose(np.array(stiffness(pose, q)), K, atol=1e-7 * np.abs(K).max())
        # At rest M qdd + g is what inverse dynamics asks for.
        qdd = np.linspace(0.3, -0.2, 5)
        forces = inverse_dynamics(
            machine, masses, pose[None], q[None, :3], np.zeros((1, 6)), (by_q @ qdd)[None], qdd[None, :3]
        )
        at_rest = np.array(equations(pose, q, np.zeros(5))[0]) @ qdd + g.ravel()
        np.testing.assert_allclose(at_rest, forces.drive_n[0], rtol=1e-7, atol=1e-6)


def test_distances_to_rails_are_those_of_many_points(machine: Machine, draw_poses: Callable):
    """No point of a link comes nearer to a rail's line than its distance, and one comes as near."""
    skewed = off_x(machine, 3, 0.2)
    sample = draw_poses(skewed, 5, 40)
    found = link_rail_distances(skewed, sample.pose, sample.q_m[:, :3])
    A, C = _joints(skewed, sample.pose, sample.q_m)
    share = np.linspace(0.0, 1.0, 2001)[:, None]
    for column, (link, rail) in enumerate(rail_pairs(skewed)):
        points = C[:, link, None] + share * (A - C)[:, link, None]
        away = points - [0.0, *skewed.rails_m[rail]]
        d = skewed.rail_directions[rail]
        nearest = np.linalg.norm(away - (away @ d)[..., None] * d, axis=2).min(axis=1)
        np.testing.assert_allclose(found[:, column], nearest, atol=1e-3)
        assert (found[:, column] <= nearest + 1e-12).all()


def _joints(machine: Machine, pose: FloatArray, q_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    R = rotation(*pose[:, 3:].T)
    feet = rail_points(machine, q_m[:, :3])[:, [0, 1, 1, 2, 2, 2]]
    return pose[:, None, :3] + machine.platform_points_m @ np.swapaxes(R, 1, 2), feet + machine.cart_offsets_m


def test_slopes_are_those_of_the_configuration(quick_config: Config, vary: Callable):
    """A rail goes through y and z where x is 0, rises as configured, and carts' positions are metres along it."""
    sloping = build_machine(vary(quick_config, {"machine.rails.1.slopes": (0.003, -0.004)}).machine)
    start, end = rail_points(sloping, np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]))[:, 1]
    np.testing.assert_allclose(start, [0.0, 0.75, 1.5])
    assert np.linalg.norm(end - start) == pytest.approx(2.0, abs=1e-15)
    np.testing.assert_allclose((end - start)[1:] / (end - start)[0], [0.003, -0.004], atol=1e-15)
    assert "slopes" not in quick_config.model_dump_json()


def test_parallel_rails_take_their_place_in_the_middle_of_their_travel(machine: Machine):
    """There both machines are alike; one whose rails are parallel is itself."""
    assert with_parallel_rails(machine) is machine
    skewed = off_x(machine, 1, 0.005)
    parallel, middle = with_parallel_rails(skewed), skewed.travel_m.mean(axis=1)[None]
    assert parallel.has_parallel_rails
    assert not skewed.has_parallel_rails
    np.testing.assert_allclose(rail_points(parallel, middle), rail_points(skewed, middle), atol=5e-5)


def test_small_slopes_change_little(machine: Machine, draw_poses: Callable):
    """Positions of carts tend to those on parallel rails, in proportion to the slopes."""
    sample, off = draw_poses(machine, 7, 60), []
    clear = (discriminants(machine, sample.pose) > 0.05).all(axis=1)
    for size in (1e-4, 1e-6):
        found = inverse_kinematics(off_x(machine, 2, size), sample.controlled[clear], sample.modes[clear])
        off.append(np.abs(found.q_m - sample.q_m[clear]).max())
    assert off[0] < 0.01
    assert off[1] == pytest.approx(off[0] / 100.0, rel=0.05)
