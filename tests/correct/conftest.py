"""A planned reconfiguration of the reference machine, and machines that are a little off."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray
from pipeline.correct import Correction, correct_path
from pipeline.export.csv import read_csv
from pipeline.export.trajectory_columns import POSE, POSITIONS
from pipeline.machine import Machine, inverse_kinematics
from pipeline.machine.geometry import MODES
from pipeline.machine.pose import CONTROLLED
from pipeline.measured.perturbed import perturbed
from pipeline.refine.result import Path as PlannedPath
from pipeline.refine.splines import DEGREE, clamped_knots, fit

REFERENCE = Path(__file__).parents[2] / "results" / "reference" / "agder" / "trajectory.csv"


def ends_of(planned: PlannedPath, machine: Machine) -> tuple[FloatArray, FloatArray]:
    """Place a machine at the planned start and goal, from LLL to RRR."""
    pose = planned.pose(np.array([0.0, 1.0]))[:, CONTROLLED]
    start, goal = inverse_kinematics(machine, pose, np.array([MODES.index("LLL"), MODES.index("RRR")])).q_m
    return start, goal


@pytest.fixture(scope="session")
def planned(machine: Machine) -> PlannedPath:
    """Fit splines to the reference motion, which changes the mode of every arm; s is its length."""
    table = read_csv(REFERENCE.read_text())
    q, pose = (np.stack([table[name] for name in names], axis=1) for names in (POSITIONS, POSE))
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1)))
    rows = np.flatnonzero(np.diff(length, prepend=-1.0) > 1e-6)
    s, knots = length[rows] / length[-1], clamped_knots(38)
    return PlannedPath(machine, BSpline(knots, fit(knots, s, q[rows]), DEGREE), s, pose[rows])


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
