"""The proven error of the tool as a file of a run."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.artifacts.results.pose_error import load_pose_error, pose_error_files, uncertainty_of
from pipeline.config import Config
from pipeline.errors import UsageError
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine import Machine
from pipeline.pose_error import DriveAmplification, PoseError
from tests.artifacts.saved import SavedRun, put
from tests.run.conftest import changed

ASKED = {"certify__pose_error": {"drives_m": [1e-4, 1e-4, 1e-4, 5e-5, 0.0], "lengths_m": 2e-5}}
ERRORS = Uncertainty(2e-5, 0.0, (1e-4, 1e-4, 1e-4, 5e-5, 0.0))


def test_it_comes_back_with_the_errors_of_the_configuration(
    tmp_path: Path, machine: Machine, fast_config: Config
) -> None:
    """There is none where none was asked for, and a damaged file is named."""
    config = changed(fast_config, **ASKED)
    assert config.certify.pose_error is not None
    assert uncertainty_of(config.certify.pose_error) == ERRORS
    gains = DriveAmplification(np.ones((2, 5)), np.full((2, 5), 3.0))
    found = PoseError(ERRORS, np.array([0.0, 0.5, 1.0]), np.array([1e-3, 2e-3]), np.array([1e-3, 3e-3]), gains)
    put(tmp_path, pose_error_files(found))
    again = load_pose_error(SavedRun(tmp_path, machine, config))
    assert again is not None
    assert again.uncertainty == ERRORS
    np.testing.assert_allclose(again.position_m, found.position_m, atol=1e-11)
    np.testing.assert_array_equal(again.edges, found.edges)
    assert load_pose_error(SavedRun(tmp_path, machine, fast_config)) is None
    put(tmp_path, {"pose_error.csv": b"s_first,s_last\n0,1\n"})
    with pytest.raises(UsageError, match=r"pose_error\.csv cannot be read"):
        load_pose_error(SavedRun(tmp_path, machine, config))
