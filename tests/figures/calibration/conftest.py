"""A calibration with an outlier, for its figures."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.calibrate import Calibration, Setting, StaticSetting, Verdict, calibrate, judge, simulate_static
from pipeline.config import Config

REFLECTORS_M = np.array([[0.0, 0.10, 0.05], [0.0, 0.40, 0.05]])


@pytest.fixture(scope="session")
def calibration(quick_config: Config) -> Calibration:
    """Calibrate from 24 poses, one point of which is far off."""
    poses = simulate_static(quick_config, REFLECTORS_M, StaticSetting(poses=24)).poses
    seen_m = poses.seen_m.copy()
    seen_m[4, 1] += 0.05
    return calibrate(quick_config, REFLECTORS_M, replace(poses, seen_m=seen_m), Setting(robust=True))


@pytest.fixture(scope="session")
def verdict(calibration: Calibration) -> Verdict:
    """Judge it."""
    return judge(calibration)
