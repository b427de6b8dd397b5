"""Errors by the number of poses."""

import numpy as np
import pytest

from pipeline.calibrate import Calibration, next_poses
from pipeline.calibrate.predict.learning import Learning, learning_curves


@pytest.fixture(scope="module")
def curves(calibration: Calibration) -> Learning:
    """Predict the errors with three poses more."""
    return learning_curves(calibration, further=3)


def test_all_curves_fall(curves: Learning):
    """A pose more never makes anything worse, and all begin with what was known beforehand."""
    for values in (curves.measured_m, curves.further_m, curves.best_m, *curves.random_m):
        assert (np.diff(values) <= 1e-15).all()
    assert len({values[0] for values in (curves.measured_m, curves.best_m, *curves.random_m)}) == 1


def test_measured_poses_end_at_the_calibration(curves: Learning):
    """All poses one by one leave what all at a time left, where the next ones begin."""
    assert curves.measured_m[-1] == pytest.approx(curves.further_m[0], rel=1e-3)


def test_chosen_poses_are_better(curves: Learning, calibration: Calibration):
    """Than those at random, whether from the start or after what was measured; these are the ones proposed."""
    assert curves.best_m[-1] < curves.random_m[:, -1].min()
    assert curves.further_m[-1] < curves.measured_m[-1]
    np.testing.assert_allclose(curves.further_m, next_poses(calibration, 3).error_m)
