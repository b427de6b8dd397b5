"""Errors over the workspace."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.calibrate import Calibration
from pipeline.calibrate.model.forward import close, positions
from pipeline.calibrate.predict.maps import ErrorMaps, error_maps
from pipeline.calibrate.verdict import measured_modes
from pipeline.machine import MODES, build_machine, inverse_kinematics
from tests.calibrate.conftest import Seen


@pytest.fixture(scope="module")
def errors(calibration: Calibration) -> ErrorMaps:
    """Map the errors of a calibration."""
    return error_maps(calibration)


def test_errors_are_as_large_as_predicted(errors: ErrorMaps, calibration: Calibration, see: Callable[..., Seen]):
    """In a cell, the true machine is off the calibrated one by a few predicted errors, the configured one by more."""
    truth, model = see(2).simulated.truth, calibration.identification.model
    own = build_machine(calibration.config.machine)
    ratios = []
    for one in errors.maps:
        z, y = (int(index) for index in np.argwhere(np.isfinite(one.calibrated_m))[len(one.mode)])
        controlled = np.array([[own.travel_m.mean(), errors.y_m[y], errors.z_m[z], 0.0, 0.0]])
        there = inverse_kinematics(own, controlled, np.array([MODES.index(one.mode)]))
        q = model.to_encoders(there.q_m)
        off = positions(model, close(model, q, there.pose)) - positions(truth, close(truth, q, there.pose))
        ratios.append(np.sqrt(np.sum(off**2) / 2.0) / one.calibrated_m[z, y])
        assert one.configured_m[z, y] > one.calibrated_m[z, y]
    assert 0.2 < np.sqrt(np.mean(np.square(ratios))) < 2.0


def test_measured_poses_are_in_their_modes(errors: ErrorMaps, calibration: Calibration):
    """Every pose is a dot in the map of its working mode."""
    counts = measured_modes(calibration.identification)
    assert {one.mode: len(one.measured_yz_m) for one in errors.maps if len(one.measured_yz_m)} == counts
