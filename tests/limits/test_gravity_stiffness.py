"""The stiffness that gravity gives the drives: as a property of potential energy, as a limit, and in words."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.limits.gravity_stiffness import GravityStiffness, for_path, for_poses, relaxations, stiffness_limit
from pipeline.machine import Machine, build_machine, forward_kinematics, inverse_kinematics
from pipeline.machine.actuator_space import actuator_rates, gravity_stiffness
from pipeline.machine.geometry import rotation
from pipeline.machine.masses import lumped_platform
from pipeline.machine.samples import PoseSamples
from pipeline.route import build_regions
from tests.conftest import CONFIGS


@pytest.fixture(scope="module")
def soft(machine: Machine) -> Machine:
    """Take the reference machine with drives that bear 800 N/m."""
    return replace(machine, gravity_stiffness_npm=-800.0)


@pytest.fixture(scope="module")
def reference_samples(soft: Machine, draw_controlled: Callable) -> PoseSamples:
    """Take random poses of the machine."""
    controlled, modes = draw_controlled(4, 400)
    solution = inverse_kinematics(soft, controlled, modes)
    return PoseSamples(soft, solution.pose, solution.q_m).take(solution.reachable)


@pytest.fixture(scope="module")
def tiny_config() -> Config:
    """Load the reference machine on the coarsest grid."""
    return load_config(CONFIGS / "tiny.yaml")


def _samples(machine: Machine, draw_poses: Callable, seed: int, kappa_max: float = 60.0) -> PoseSamples:
    drawn = draw_poses(machine, seed, 60, kappa_max)
    return PoseSamples(machine, drawn.pose, drawn.q_m)


def _potential(machine: Machine, q_m: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Potential energy of the lumped platform where the links close."""
    body = lumped_platform(machine.masses, machine.platform_points_m)
    pose = forward_kinematics(machine, q_m, near, tolerance_m=1e-12)
    return -body.mass_kg * (pose[:, :3] + rotation(*pose.T[3:]) @ body.centre_m) @ machine.masses.gravity_mps2


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_no_direction_bends_potential_energy_more(soft: Machine, draw_poses: Callable, seed: int):
    """Along its own direction the second difference is the least eigenvalue, and along any other it is not less."""
    samples, h = _samples(soft, draw_poses, seed, 30.0), 2e-4
    K = gravity_stiffness(soft, actuator_rates(soft, samples.pose, samples.carts_m))
    own = np.linalg.eigh(K)[1][:, :, 0]
    least, allowed = samples.gravity_stiffness_npm, 1e-3 * np.abs(K).max(axis=(1, 2)) + 5.0
    other = np.random.default_rng(seed).normal(size=own.shape)
    for direction, exact in ((own, True), (other / np.linalg.norm(other, axis=1, keepdims=True), False)):
        V = [_potential(soft, samples.q_m + step * direction, samples.pose) for step in (-h, 0.0, h)]
        bend = (V[2] - 2.0 * V[1] + V[0]) / h**2
        assert (bend >= least - allowed).all()
        if exact:
            assert (np.abs(bend - least) <= allowed).all()


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_it_is_never_positive(soft: Machine, draw_poses: Callable, seed: int):
    """Carts moved alike along X carry everything along: K has that eigenvector, with eigenvalue zero."""
    samples = _samples(soft, draw_poses, seed)
    K = gravity_stiffness(soft, actuator_rates(soft, samples.pose, samples.carts_m))
    along_x = K @ np.array([1.0, 1.0, 1.0, 0.0, 0.0])
    assert np.abs(along_x).max() <= 1e-9 * np.abs(K).max()
    assert (samples.gravity_stiffness_npm <= 1e-9 * np.abs(K).max()).all()


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_a_pose_is_kept_exactly_if_drives_that_stiff_hold_it(soft: Machine, draw_poses: Callable, seed: int):
    """Springs of the limit's size in every drive make the energy convex; margins, values and excess agree."""
    samples = _samples(soft, draw_poses, seed)
    (limit,) = for_poses(soft, 100.0)
    assert isinstance(limit, GravityStiffness)
    K = gravity_stiffness(soft, actuator_rates(soft, samples.pose, samples.carts_m))
    held = [bool((np.linalg.eigvals(one + 800.0 * np.eye(5)).real >= 0.0).all()) for one in K]
    margins = limit.margins(samples)
    np.testing.assert_array_equal(margins[:, 0] >= 0.0, held)
    np.testing.assert_array_equal(margins >= 0.0, limit.values(samples) >= 0.0)
    np.testing.assert_array_equal(margins >= 0.0, limit.excess(samples) <= 0.0)


def test_at_a_singular_pose_the_margin_is_minus_one(soft: Machine):
    """No stiffness is known there; the margin tends to that, and nothing fails."""
    limit = stiffness_limit(soft)
    assert limit is not None
    samples = PoseSamples(soft, np.tile([1.0, 0.3, 0.9, 0.0, 0.0, 0.0], (2, 1)), np.ones((2, 5)))
    samples = samples.with_known(H=np.stack([np.zeros((6, 6)), np.eye(6)]))
    assert samples.gravity_stiffness_npm[0] == -np.inf
    assert limit.margins(samples)[0, 0] == -1.0
    assert limit.margins(samples.with_known(gravity_stiffness_npm=np.array([-1e12, 0.0])))[0, 0] < -0.999
    (message,) = limit.violations(samples.take(np.array([0])))
    assert message.startswith("has a gravity stiffness of -inf N/m; machine.limits.gravity_stiffness_npm asks")


def test_regions_are_those_that_can_be_held(tiny_config: Config, machine: Machine):
    """Regions without the limit, less those that break it."""
    every = build_regions(tiny_config, machine)
    soft = replace(machine, gravity_stiffness_npm=float(np.quantile(every.samples(machine).gravity_stiffness_npm, 0.3)))
    held = build_regions(tiny_config, soft)
    (limit,) = for_poses(soft, 100.0)
    keeps = (limit.margins(every.samples(soft)) >= 0.0).all(axis=1)
    assert 0 < np.count_nonzero(~keeps) < len(every) / 2
    np.testing.assert_array_equal(every.take(keeps).controlled, held.controlled)


def test_milder_limits_are_lower_and_cut_the_table(tiny_config: Config, machine: Machine, vary: Callable):
    """In steps of 100 N/m: a generous table cut down is the one that is built with the value."""
    config = vary(tiny_config, {"machine.limits.gravity_stiffness_npm": -250.0})
    (relaxation,) = relaxations(config, build_machine(config.machine))
    assert relaxation.levels[:3].tolist() == [-250.0, -300.0, -400.0]
    assert (np.diff(relaxation.levels) < 0.0).all()
    wide, built = (
        build_regions(changed, build_machine(changed.machine))
        for changed in (relaxation.change(value) for value in (-100_000.0, -1_000.0))
    )
    _, inside = relaxation.prepare(wide.samples(machine), wide.x_window_m)(-1_000.0)
    assert 0 < len(built) < len(wide)
    np.testing.assert_array_equal(wide.take(inside).controlled, built.controlled)
    assert relaxations(tiny_config, machine) == []


def test_the_words_name_stiffness_direction_and_limit(soft: Machine, reference_samples: PoseSamples):
    """A pose that is too unstable is told by how much, and along which drives."""
    limit = stiffness_limit(soft)
    assert limit is not None
    worst = int(reference_samples.gravity_stiffness_npm.argmin())
    (message,) = limit.violations(reference_samples.take(np.array([worst])))
    stiffness = reference_samples.gravity_stiffness_npm[worst]
    assert stiffness < -800.0
    assert message.startswith(f"has a gravity stiffness of {stiffness:.0f} N/m along ")
    assert message.endswith("; machine.limits.gravity_stiffness_npm asks for at least -800 N/m")
    assert limit.violations(reference_samples.take(np.array([reference_samples.gravity_stiffness_npm.argmax()]))) == []


def test_without_masses_or_limit_there_is_none(quick_config: Config, soft: Machine):
    """Nothing is checked that is not asked for, or cannot be known."""
    for machine in (replace(soft, masses=None), replace(soft, gravity_stiffness_npm=-np.inf)):
        assert for_path(quick_config, machine) == []
        assert for_poses(machine, 100.0) == []
