"""Reference values, random poses and random machines."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine import InverseSolution, Machine, inverse_kinematics
from pipeline.machine.geometry import MODES

DATA = Path(__file__).parents[1] / "data" / "kinematics.json"


@dataclass(frozen=True, eq=False)
class Reference:
    """Forty poses of the reference machine, five per working mode, computed independently."""

    controlled: FloatArray
    modes: IntArray
    column: Callable[[str], FloatArray]


@pytest.fixture(scope="session")
def reference() -> Reference:
    """Read the reference values."""
    poses = json.loads(DATA.read_text())["poses"]
    keys = ("x_m", "y_m", "z_m", "rx_rad", "rz_rad")
    return Reference(
        controlled=np.array([[pose[key] for key in keys] for pose in poses]),
        modes=np.array([MODES.index(pose["mode"]) for pose in poses]),
        column=lambda key: np.array([pose[key] for pose in poses]),
    )


@pytest.fixture(scope="session")
def reference_solution(machine: Machine, reference: Reference) -> InverseSolution:
    """Solve the inverse kinematics of all reference poses."""
    return inverse_kinematics(machine, reference.controlled, reference.modes)
