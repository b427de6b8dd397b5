"""Which poses to measure next."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.calibrate import Setting, StaticPoses, calibrate, first_poses, next_poses
from pipeline.calibrate.model.forward import close, positions
from pipeline.config import Config
from pipeline.machine import Machine, condition_number, det_sign, statics_matrix
from tests.calibrate.conftest import REFLECTORS_M, Seen


def test_first_poses_are_moderate(quick_config: Config, machine: Machine):
    """A dozen poses in several modes and on one side of the singularities, whose predicted errors fall."""
    found = first_poses(quick_config, REFLECTORS_M[:2], Setting(), 12)
    assert found.kappa.max() <= 25.0
    H = statics_matrix(machine, found.pose, found.q_m[:, :3])
    np.testing.assert_allclose(condition_number(H), found.kappa)
    assert len(set(det_sign(H).tolist())) == 1
    assert len(set(found.modes)) > 1
    assert (np.diff(found.error_m) < 0.0).all()
    assert len(np.unique(found.q_m, axis=0)) == 12


def test_prediction_is_that_of_a_calibration_with_them(see: Callable[..., Seen], quick_config: Config):
    """Measured, the proposed poses leave the covariance that was predicted, and more than as many at random do."""
    seen = see(2, poses=20)
    truth, poses = seen.simulated.truth, seen.simulated.poses
    before = calibrate(quick_config, REFLECTORS_M[:2], poses, Setting())
    proposed = next_poses(before, 10)
    assert proposed.kappa.max() <= 40.0
    new = positions(truth, close(truth, proposed.q_m, proposed.pose))
    both = StaticPoses(np.concatenate([poses.q_m, proposed.q_m]), np.concatenate([poses.seen_m, new]))
    after = calibrate(quick_config, REFLECTORS_M[:2], both, Setting()).identification
    fitted = after.problem.is_fitted
    determinants = [
        np.linalg.slogdet(one.covariance[np.ix_(fitted, fitted)])[1] for one in (before.identification, after)
    ]
    elsewhere = see(2, poses=30)
    random = calibrate(quick_config, REFLECTORS_M[:2], elsewhere.simulated.poses, Setting()).identification
    assert determinants[1] < np.linalg.slogdet(random.covariance[np.ix_(fitted, fitted)])[1] - 5.0
    assert determinants[1] < determinants[0] - 20.0
    assert proposed.error_m[-1] < 0.6 * proposed.error_m[0]


@pytest.mark.slow
def test_two_stages_make_a_machine_accurate(see: Callable[..., Seen], quick_config: Config):
    """Twelve moderate poses and 28 next-best ones leave at most 0.035 mm at the TCP, rms over the workspace."""
    first = first_poses(quick_config, REFLECTORS_M[:2], Setting(), 12)
    squares = []
    for seed in range(3):
        seen, random = see(2, seed=seed), np.random.default_rng(seed)
        truth = seen.simulated.truth

        def measure(q: np.ndarray, pose: np.ndarray, truth=truth, random=random) -> np.ndarray:
            where = positions(truth, close(truth, q, pose))
            return where + random.normal(0.0, 5e-5, where.shape)

        poses = StaticPoses(first.q_m, measure(first.q_m, first.pose))
        then = next_poses(calibrate(quick_config, REFLECTORS_M[:2], poses, Setting()), 28)
        seen_m = np.concatenate([poses.seen_m, measure(then.q_m, then.pose)])
        both = StaticPoses(np.concatenate([first.q_m, then.q_m]), seen_m)
        found = calibrate(quick_config, REFLECTORS_M[:2], both, Setting()).identification.model
        elsewhere = see(2, poses=60, seed=1000).simulated
        q, guess = elsewhere.poses.q_m, elsewhere.configured_pose
        found_tcp, true_tcp = (replace(model, reflectors_m=np.zeros((1, 3))) for model in (found, truth))
        off = (positions(found_tcp, close(found, q, guess)) - positions(true_tcp, close(truth, q, guess)))[:, 0]
        in_platform = np.einsum("nji,nj->ni", truth.rotation @ close(truth, q, guess).R, off)
        squares.append(np.sum((in_platform - in_platform.mean(axis=0)) ** 2, axis=1).mean())
    assert np.sqrt(np.mean(squares)) < 3.5e-5
