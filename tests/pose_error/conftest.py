"""Fixtures of the tool's error: a short path, and what is proven of it."""

import numpy as np
import pytest

from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine import Machine
from pipeline.pose_error import PoseError, bound_pose_error
from pipeline.refine import Path
from tests.certify.paths import line_path

DRIVES = Uncertainty(actuator_m=(1e-4,) * 5)
EVERYTHING = Uncertainty(4e-5, 2e-5, (1e-4, 1e-4, 1e-4, 5e-5, 0.0))


@pytest.fixture(scope="session")
def line(machine: Machine) -> Path:
    """Make a short regular path."""
    return line_path(machine)


@pytest.fixture(scope="session")
def of_drives(line: Path) -> PoseError:
    """Bound the error for drives that are off alike."""
    return bound_pose_error(line, DRIVES)


@pytest.fixture(scope="session")
def of_everything(line: Path) -> PoseError:
    """Bound the error for drives and a geometry that are off."""
    return bound_pose_error(line, EVERYTHING)


def bound_at(found: PoseError, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give the bounds of position and rotation at s (n,): at an edge the smaller one of both intervals, which hold."""
    rows = [
        (np.searchsorted(found.edges, s, side=side) - 1).clip(0, len(found.position_m) - 1)
        for side in ("left", "right")
    ]
    return tuple(np.minimum(*(values[row] for row in rows)) for values in (found.position_m, found.rotation_rad))
