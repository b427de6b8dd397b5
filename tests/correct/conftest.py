"""A planned reconfiguration of the reference machine, and machines that are a little off."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.arrays import FloatArray
from pipeline.correct import Correction, correct_path
from pipeline.machine import Machine, inverse_kinematics
from pipeline.machine.geometry import MODES
from pipeline.machine.pose import CONTROLLED
from pipeline.measured.perturbed import perturbed
from pipeline.refine.result import Path as PlannedPath
from tests.reference import reference_path


def ends_of(planned: PlannedPath, machine: Machine) -> tuple[FloatArray, FloatArray]:
    """Place a machine at the planned start and goal, from LLL to RRR."""
    pose = planned.pose(np.array([0.0, 1.0]))[:, CONTROLLED]
    start, goal = inverse_kinematics(machine, pose, np.array([MODES.index("LLL"), MODES.index("RRR")])).q_m
    return start, goal


@pytest.fixture(scope="session")
def planned(machine: Machine) -> PlannedPath:
    """Give the reference motion as splines."""
    return reference_path(machine)


@pytest.fixture(scope="session")
def corrected(planned: PlannedPath, real: Machine) -> Correction:
    """Correct the planned path for that machine."""
    return correct_path(planned, real, ends_of(planned, real))


@pytest.fixture(scope="session")
def ends() -> Callable[[PlannedPath, Machine], tuple[FloatArray, FloatArray]]:
    """Give tests `ends_of`."""
    return ends_of


@pytest.fixture(scope="session")
def real(machine: Machine) -> Machine:
    """Draw a machine whose joints, rails and lengths are off by 0.2 mm."""
    return perturbed(machine, 2e-4, np.random.default_rng(4))[0]
