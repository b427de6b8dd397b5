"""The stage that proves a path: its files and its part of the summary."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.progress import QUIET
from pipeline.refine.result import Refinement
from pipeline.run.makers.certificate import make_certificate
from pipeline.run.results import Results
from pipeline.stage import Stage
from pipeline.status import Status
from tests.certify.paths import START, pose_path
from tests.run.conftest import changed


@pytest.fixture
def task(agder_config: Config) -> Config:
    """Ask for a short way."""
    goal = {"x_m": 1.03, "y_m": 0.31, "z_m": 0.89, "rx_deg": 0.0, "rz_deg": 0.0, "mode": "LLL"}
    return changed(agder_config, task__goal=goal)


def test_the_error_of_the_tool_is_proven_on_request(tmp_path: Path, machine: Machine, task: Config) -> None:
    """With its file and its figures in the summary; null there where it was not asked for."""
    path = pose_path(machine, np.linspace(START, [1.03, 0.31, 0.89, 0.0, 0.0], 7), 0, 7)

    def made(config: Config) -> tuple[set[str], dict]:
        results = Results(config, machine, tmp_path)
        results.keep(Stage.REFINE, Refinement(path, path, Status.CONVERGED, 1, 1, 1, None, 1, 0.0))
        product = make_certificate(results, QUIET)
        return set(product.files), product.section

    files, section = made(task)
    assert files == {"certificate.json"}
    assert section["pose_error_bound_m"] is None
    files, section = made(changed(task, certify__pose_error={"drives_m": [1e-4] * 5}))
    assert files == {"certificate.json", "pose_error.csv", "pose_error.npz"}
    assert 1e-4 < section["pose_error_bound_m"] < 2e-3
    assert 0.0 < section["pose_error_rotation_rad"] < 2e-3
    assert len(section["amplification_max"]) == len(section["amplification_max_s"]) == 5
    assert all(0.0 <= section[key] <= 1.0 for key in ("pose_error_bound_s", "pose_error_rotation_s"))
