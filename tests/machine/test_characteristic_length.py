"""Machines of any size: with lengths and characteristic length in proportion, kappa is the same everywhere."""

from dataclasses import replace

import casadi as ca
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.config import Config
from pipeline.machine import Machine, build_machine, inverse_kinematics
from pipeline.machine.samples import PoseSamples
from pipeline.machine.statics import moment_unit
from pipeline.machine.symbolic import holding_function
from pipeline.refine.collocation.node_kappa import NodeKappa
from tests.scaling import scaled

sizes = st.floats(0.05, 8.0)
seeds = st.integers(0, 2**32 - 1)
LENGTHS = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
"""Which coordinates of a pose are lengths."""


def _larger(samples: PoseSamples, config: Config, k: float) -> PoseSamples:
    """The same poses of the machine k times as large."""
    return PoseSamples(build_machine(scaled(config, k).machine), samples.pose * k**LENGTHS, k * samples.q_m)


@given(k=sizes, seed=seeds)
@settings(max_examples=30)
def test_kappa_forces_and_distances(agder_config: Config, machine: Machine, draw_poses, k: float, seed: int):
    """Kappa, the sign of det H and holding forces are the same, distances are k times as large."""
    drawn = draw_poses(machine, seed, 40)
    small = PoseSamples(machine, drawn.pose, drawn.q_m)
    large = _larger(small, agder_config, k)
    np.testing.assert_allclose(large.kappa, small.kappa, rtol=1e-9)
    np.testing.assert_array_equal(large.det_sign, small.det_sign)
    np.testing.assert_allclose(large.holding_forces_n, small.holding_forces_n, rtol=1e-8, atol=1e-6)
    np.testing.assert_allclose(large.link_distances_m, k * small.link_distances_m, rtol=1e-8, atol=1e-9)
    solution = inverse_kinematics(large.machine, drawn.controlled * k ** LENGTHS[[0, 1, 2, 3, 5]], drawn.modes)
    np.testing.assert_allclose(solution.q_m, large.q_m, rtol=1e-8)


@given(length_m=sizes, seed=seeds)
@settings(max_examples=20)
def test_moments_are_divided_by_it(machine: Machine, draw_poses, length_m: float, seed: int):
    """By hand: forces as they are, moments less, and the links' forces balance the same wrench."""
    drawn = draw_poses(machine, seed, 20)
    of_metres = PoseSamples(machine, drawn.pose, drawn.q_m)
    other = PoseSamples(replace(machine, characteristic_length_m=length_m), drawn.pose, drawn.q_m)
    by_hand = np.diag([1.0, 1.0, 1.0, *[1.0 / length_m] * 3]) @ of_metres.H
    np.testing.assert_allclose(other.H, by_hand, rtol=1e-12)
    np.testing.assert_allclose(other.kappa, np.linalg.cond(by_hand), rtol=1e-8)
    np.testing.assert_allclose(other.holding_forces_n, of_metres.holding_forces_n, rtol=1e-8, atol=1e-6)


@given(length_m=sizes, seed=seeds)
@settings(max_examples=10)
def test_equilibrium_in_casadi_does_not_depend_on_it(machine: Machine, draw_poses, length_m: float, seed: int):
    """Forces that hold the machine leave no residual, and give the same drives, for any characteristic length."""
    drawn = draw_poses(machine, seed, 5)
    samples = PoseSamples(machine, drawn.pose, drawn.q_m)
    function = holding_function(replace(machine, characteristic_length_m=length_m))
    forces = samples.holding_forces_n
    residual, drives = function.map(len(samples))(samples.pose.T, samples.q_m.T, forces[:, 5:].T)
    scale = 1.0 + np.abs(forces).max()
    assert np.abs(np.array(residual)).max() < 1e-9 * scale * max(1.0, 1.0 / length_m)
    np.testing.assert_allclose(np.array(drives).T, forces[:, :5], atol=1e-9 * scale)


@given(k=sizes, seed=seeds)
@settings(max_examples=10)
def test_smooth_kappa_of_the_program(agder_config: Config, machine: Machine, draw_poses, k: float, seed: int):
    """The objective of stage two, and its derivatives by lengths, which fall with the size."""
    drawn = draw_poses(machine, seed, 4)
    small = PoseSamples(machine, drawn.pose, drawn.q_m)
    large = _larger(small, agder_config, k)
    found, by = [], np.append(k**LENGTHS, [k] * 3)
    for samples in (small, large):
        nodes = np.vstack([samples.pose.T, samples.carts_m.T])
        kappa = NodeKappa(samples.machine, len(samples), 64.0)
        found.append([np.array(part) for part in kappa.eval([ca.DM(nodes)])])
    one, other = found
    np.testing.assert_allclose(other[0], one[0], rtol=1e-8)
    np.testing.assert_allclose(other[1] * by[:, None], one[1], rtol=1e-6, atol=1e-6 * np.abs(one[1]).max())


def test_the_unit_is_said(machine: Machine):
    """Metres, as in the paper, or what moments are divided by."""
    assert moment_unit(machine) == "moments in m"
    assert moment_unit(replace(machine, characteristic_length_m=0.25)) == "moments per 0.25 m"
