"""First estimates of clock offsets."""

import numpy as np
import pytest

from pipeline.calibrate import DrivenMotion, StaticSetting, simulate_motion
from pipeline.calibrate.estimate.clocks import first_clocks
from pipeline.calibrate.model.model import configured_model
from pipeline.config import Config
from tests.calibrate.conftest import REFLECTORS_M


@pytest.mark.parametrize("late_s", [-1.9, 0.0, 0.512])
def test_offsets_up_to_two_seconds_are_found(quick_config: Config, driven: DrivenMotion, late_s: float) -> None:
    """They are right to some milliseconds, whatever the tracker's frame, and with points that are wrong."""
    setting = StaticSetting(poses=5, outliers=0.1)
    poses = simulate_motion(quick_config, REFLECTORS_M[:2], driven, setting, late_s).poses
    model = configured_model(quick_config.machine, REFLECTORS_M[:2]).with_clocks(np.zeros(1))
    assert first_clocks(model, poses) == pytest.approx([late_s], abs=0.008)


def test_static_poses_have_no_clock(quick_config: Config, see) -> None:
    """There is nothing to estimate."""
    model = configured_model(quick_config.machine, REFLECTORS_M[:2])
    assert first_clocks(model, see(2).simulated.poses).shape == (0,)
