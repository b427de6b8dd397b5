"""A calibration to predict from."""

from collections.abc import Callable

import pytest

from pipeline.calibrate import Calibration, Setting, calibrate
from pipeline.config import Config
from tests.calibrate.conftest import REFLECTORS_M, Seen


@pytest.fixture(scope="session")
def calibration(see: Callable[..., Seen], quick_config: Config) -> Calibration:
    """Calibrate from all poses of a simulated measurement."""
    return calibrate(quick_config, REFLECTORS_M[:2], see(2).simulated.poses, Setting())
