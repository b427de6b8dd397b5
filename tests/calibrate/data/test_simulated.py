"""Simulated measurements of static poses."""

from collections.abc import Callable

import numpy as np

from pipeline.calibrate.model.forward import close, positions
from pipeline.calibrate.model.parameters import DIRECTIONS, SCALES, TRACKER
from tests.calibrate.conftest import Seen


def test_points_are_those_of_the_true_machine_and_noise(see: Callable[..., Seen]):
    """Without noise they are exactly where the true machine has them; noise and outliers have their sizes."""
    exact = see(2, poses=30, noise_m=0.0).simulated
    where = positions(exact.truth, close(exact.truth, exact.poses.q_m, exact.configured_pose))
    np.testing.assert_allclose(exact.poses.seen_m, where, atol=1e-14)
    noisy = see(2, poses=300, noise_m=1e-4, outliers=0.1).simulated
    where = positions(noisy.truth, close(noisy.truth, noisy.poses.q_m, noisy.configured_pose))
    off = noisy.poses.seen_m - where
    assert abs(off[~noisy.is_outlier].std() / 1e-4 - 1.0) < 0.06
    assert abs(noisy.is_outlier.mean() - 0.1) < 0.04
    np.testing.assert_allclose(np.linalg.norm(off[noisy.is_outlier], axis=1), 0.05, atol=1e-3)


def test_the_machine_is_off_as_asked(see: Callable[..., Seen]):
    """Deviations have their sizes by kind, rails are parallel unless asked otherwise, and seeds repeat."""
    seen = see(2, poses=5, geometry_std_m=1e-3, scale_std=1e-5, seed=9)
    parameters = seen.configured.parameters
    theta = seen.simulated.truth.values() - seen.configured.values()
    assert not parameters.of(DIRECTIONS, theta).any()
    assert 3e-6 < parameters.of(SCALES, theta).std() < 3e-5
    rest = np.delete(theta, np.r_[parameters.slice(SCALES), parameters.slice(DIRECTIONS), parameters.slice(TRACKER)])
    assert 0.7e-3 < rest.std() < 1.4e-3
    again = see(2, poses=5, geometry_std_m=1e-3, scale_std=1e-5, seed=9)
    np.testing.assert_array_equal(again.simulated.poses.seen_m, seen.simulated.poses.seen_m)
    assert parameters.of(DIRECTIONS, see(2, poses=5, direction_std_rad=1e-4).simulated.truth.values()).all()


def test_the_same_machine_is_measured_elsewhere(see: Callable[..., Seen]):
    """Where it is assembled near other poses, with noise that repeats for the same encoders only."""
    simulated = see(2, poses=30).simulated
    q, near = simulated.poses.q_m[:20] + 1e-4, simulated.configured_pose[:20]
    again, other = simulated.measure(q, near), simulated.measure(q[::-1], near[::-1])
    where = positions(simulated.truth, close(simulated.truth, q, near))
    assert abs((again.seen_m - where).std() / simulated.noise_m - 1.0) < 0.25
    np.testing.assert_array_equal(simulated.measure(q, near).seen_m, again.seen_m)
    assert np.abs(other.seen_m[::-1] - again.seen_m).min() > 1e-12


def test_measurements_are_joined(see: Callable[..., Seen]):
    """Rows of both, each told as where it was."""
    poses = see(2, poses=30).simulated.poses
    one, other = poses.at(np.arange(3)), poses.at(np.arange(10, 14))
    both = one.joined(other)
    np.testing.assert_array_equal(both.q_m, poses.q_m[[0, 1, 2, 10, 11, 12, 13]])
    assert [both.place(row) for row in (2, 3)] == [poses.place(2), poses.place(10)]
