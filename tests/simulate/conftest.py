"""The reference motion as it is kept, sampled finely, and how the reference machine's drives are given."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BPoly, CubicSpline

from pipeline.config import Config
from pipeline.export.csv import read_csv
from pipeline.machine import Machine, build_machine
from pipeline.simulate import Drives, Motion, build_drives, ideal_drives
from tests.simulate.motions import make_motion

REFERENCE = Path(__file__).parents[2] / "results" / "reference" / "agder" / "trajectory.csv"


@pytest.fixture(scope="session")
def agder(agder_config: Config) -> Machine:
    """Build the reference machine."""
    return build_machine(agder_config.machine)


@pytest.fixture(scope="session")
def drives(agder_config: Config, agder: Machine) -> Drives:
    """Give the drives that are assumed."""
    return build_drives(agder_config.drives, agder)


@pytest.fixture(scope="session")
def ideal(drives: Drives) -> Drives:
    """Give the same controllers with ideal drives."""
    return ideal_drives(drives)


@pytest.fixture(scope="session")
def reference(agder: Machine) -> Motion:
    """Sample the motion that is kept with the reference results every millisecond."""
    kept = read_csv(REFERENCE.read_text())
    t, q, qd, qdd = (
        kept["t_s"],
        *(
            np.column_stack([kept[f"{name}{k}_{unit}"] for k in range(1, 6)])
            for name, unit in (("q", "m"), ("qd", "mps"), ("qdd", "mps2"))
        ),
    )
    pose = np.column_stack([kept[name] for name in ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")])
    curve = BPoly.from_derivatives(t, np.stack([q, qd, qdd], axis=1))
    return make_motion(agder, curve, CubicSpline(t, pose), 1e-3)
