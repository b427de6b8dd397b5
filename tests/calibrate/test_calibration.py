"""A calibration from files' poses to errors at poses that took no part."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.calibrate import Setting, calibrate
from pipeline.config import Config
from pipeline.errors import ArgumentError, UsageError
from tests.calibrate.conftest import REFLECTORS_M, Seen


def test_errors_are_as_predicted(see: Callable[..., Seen], quick_config: Config):
    """Over some machines errors at fitted and at held-out poses are within 10 % of what the covariance says."""
    fitted, held = [], []
    for seed in range(5):
        poses = see(2, poses=80, seed=seed).simulated.poses
        found = calibrate(quick_config, REFLECTORS_M[:2], poses, Setting(hold_out=0.5))
        fitted.append((found.fitted.after_m, found.fitted.predicted_m))
        assert found.held_out is not None
        assert found.held_out.points == found.fitted.points == 80
        assert found.held_out.before_m > 5.0 * found.held_out.after_m
        held.append((found.held_out.after_m, found.held_out.predicted_m))
    for pairs in (fitted, held):
        after, predicted = np.sqrt(np.mean(np.square(pairs), axis=0))
        assert abs(after / predicted - 1.0) < 0.1


def test_held_out_outliers_are_left_out_of_the_check(see: Callable[..., Seen], quick_config: Config):
    """A robust calibration counts them, on both sides, and judges by the other points."""
    seen = see(2, poses=60, outliers=0.08, seed=2)
    found = calibrate(quick_config, REFLECTORS_M[:2], seen.simulated.poses, Setting(robust=True, hold_out=0.4))
    assert found.held_out is not None
    assert found.held_out.rejected > 0
    assert found.fitted.rejected + found.held_out.rejected == seen.simulated.is_outlier.sum()
    assert found.held_out.after_m < 1.5 * found.held_out.predicted_m


def test_poses_without_a_reflector_do_not_count(see: Callable[..., Seen], quick_config: Config):
    """Rows in which nothing was seen change nothing, and with hardly any others there is no calibration."""
    poses = see(2, poses=30).simulated.poses
    hidden = replace(poses, seen_m=np.concatenate([poses.seen_m[:28], np.full((2, 2, 3), np.nan)]))
    found = calibrate(quick_config, REFLECTORS_M[:2], hidden, Setting())
    expected = calibrate(quick_config, REFLECTORS_M[:2], poses.at(np.arange(28)), Setting())
    np.testing.assert_array_equal(found.identification.theta, expected.identification.theta)
    with pytest.raises(UsageError, match="2 poses with a reflector are too few"):
        calibrate(quick_config, REFLECTORS_M[:2], poses.at(np.arange(2)), Setting())


@pytest.mark.parametrize("wrong", [{"noise_m": 0.0}, {"hold_out": 0.95}, {"prior": {"rails": -1.0}}])
def test_settings_are_checked(wrong: dict[str, object]):
    """Noise and priors are positive, and something is left to fit."""
    with pytest.raises(ArgumentError):
        Setting(**wrong)  # type: ignore[arg-type]
