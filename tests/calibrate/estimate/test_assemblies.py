"""How a machine may be assembled where its encoders show q."""

import numpy as np
import pytest

from pipeline.calibrate.data.design import random_poses
from pipeline.calibrate.estimate.assemblies import assemblies
from pipeline.config import Config
from pipeline.machine import Machine, det_sign, statics_matrix
from pipeline.machine.kinematics import closure_residual


@pytest.fixture(scope="module")
def measured(quick_config: Config):
    """Draw poses up to a kappa of 60 in all working modes."""
    return random_poses(quick_config, 80, np.random.default_rng(4), 60.0)


def test_the_true_assembly_is_among_them(quick_config: Config, machine: Machine, measured):
    """Every pose is found from its actuators alone, with at most a few others, all closed and of the same det H."""
    found = assemblies(quick_config, measured.q_m)
    sign = det_sign(statics_matrix(machine, measured.pose[:1], measured.q_m[:1, :3]))[0]
    for row, poses in enumerate(found):
        assert 1 <= len(poses) <= 4
        assert np.abs(poses - measured.pose[row]).max(axis=1).min() < 1e-8
        q = np.broadcast_to(measured.q_m[row], (len(poses), 5))
        assert np.abs(closure_residual(machine, poses, q)).max() < 1e-9
        assert (det_sign(statics_matrix(machine, poses, q[:, :3])) == sign).all()


def test_there_may_be_none(quick_config: Config):
    """Carts a rail's length apart cannot hold the platform together."""
    assert [len(poses) for poses in assemblies(quick_config, np.array([[0.0, 2.1, 0.0, 1.1, 1.2]]))] == [0]
