"""A machine as numbers that a calibration may change."""

from collections.abc import Callable

import numpy as np

from pipeline.calibrate.model.parameters import TRACKER
from tests.calibrate.conftest import Seen


def test_deviations_add_to_its_values(see: Callable[..., Seen]):
    """Whatever the deviations, the moved machine has the sum for its values; none at all change nothing."""
    model = see(3, poses=5, direction_std_rad=1e-4).simulated.truth
    theta = np.random.default_rng(1).normal(size=model.parameters.count)
    model.parameters.of(TRACKER, theta)[:] = 0.0
    np.testing.assert_allclose(model.moved(theta).values(), model.values() + theta, atol=1e-15)
    np.testing.assert_array_equal(model.moved(np.zeros_like(theta)).values(), model.values())


def test_encoders_show_what_actuators_are(see: Callable[..., Seen]):
    """Converting to encoders and back changes nothing, with zeros and scales that are not the usual ones."""
    model = see(1, poses=5).simulated.truth
    q = np.random.default_rng(2).uniform(0.0, 2.0, (20, 5))
    assert np.abs(model.actuators(q) - q).max() > 1e-4
    np.testing.assert_allclose(model.actuators(model.to_encoders(q)), q, atol=1e-15)
