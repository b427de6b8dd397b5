"""Poses that a machine can be measured at."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.calibrate.data.design import random_poses
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.limits import admitted, pose_limits
from pipeline.machine import Machine, condition_number, det_sign, link_distances, statics_matrix
from pipeline.machine.kinematics import closure_residual
from pipeline.machine.samples import PoseSamples
from pipeline.machine.working_modes import mode_names, reach_along_rails, working_modes


def test_poses_keep_all_limits(quick_config: Config, machine: Machine):
    """Closed, within actuators, tilts, distances and kappa, on one side of the singularities, in several modes."""
    found = random_poses(quick_config, 60, np.random.default_rng(1), 25.0)
    pose, q = found.pose, found.q_m
    assert len(pose) == 60
    assert np.abs(closure_residual(machine, pose, q)).max() < 1e-12
    limits = machine.actuator_limits_m
    assert ((q >= limits[:, 0]) & (q <= limits[:, 1])).all()
    assert np.rad2deg(np.abs(pose[:, [3, 5]])).max() <= quick_config.task.tilt_max_deg
    H = statics_matrix(machine, pose, q[:, :3])
    assert condition_number(H).max() <= 25.0
    assert len(set(det_sign(H).tolist())) == 1
    assert link_distances(machine, pose, q[:, :3]).min() >= machine.link_link_m
    modes = {mode_names(working_modes(row[None]))[0] for row in reach_along_rails(machine, pose, q[:, :3])}
    assert {"LLL", "RRR"} < modes


def test_locked_axes_stay_locked(quick_config: Config, vary: Callable):
    """A 4-DOF machine is measured with its tilt at zero."""
    config = vary(quick_config, {"task.locked_axes": ["rx"]})
    found = random_poses(config, 10, np.random.default_rng(1), 60.0)
    assert (found.pose[:, 3] == 0.0).all()
    assert (found.pose[:, 5] != 0.0).all()


def test_too_few_poses_are_reported(quick_config: Config):
    """No pose has a kappa of one."""
    with pytest.raises(NoSolutionError, match="have 0 that can be measured"):
        random_poses(quick_config, 1, np.random.default_rng(1), 1.0)


def test_bodies_keep_their_distances(bodies_config: Config, bodies_machine: Machine):
    """A machine with bodies, of which axes of links need not keep any, has poses, and keeps all its limits there."""
    found = random_poses(bodies_config, 5, np.random.default_rng(0), 40.0)
    samples = PoseSamples(bodies_machine, found.pose, found.q_m)
    assert len(admitted(pose_limits(bodies_machine, 40.0), samples)[0]) == 5
