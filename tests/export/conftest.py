"""A sampled motion to be written in all formats: real samples, with every sign and size of number."""

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest

from pipeline.export import read_csv
from pipeline.export.trajectory_columns import ACCELERATIONS, POSE, POSITIONS, VELOCITIES
from pipeline.retime import TrajectorySamples

SampleMaker = Callable[[float], TrajectorySamples]


@pytest.fixture(scope="session")
def make_samples() -> SampleMaker:
    """Make samples at a period: five actuators on different smooth curves, from rest to rest in 0.2 seconds."""

    def make(period_s: float) -> TrajectorySamples:
        rows = max(2, round(0.2 / period_s) + 1)
        t = period_s * np.arange(rows)
        r = t / t[-1]
        travel = np.array([0.02, -0.015, 1e-7, 0.004, -0.002])
        rise, speed, push = (
            10 * r**3 - 15 * r**4 + 6 * r**5,
            (30 * r**2 - 60 * r**3 + 30 * r**4) / t[-1],
            (60 * r - 180 * r**2 + 120 * r**3) / t[-1] ** 2,
        )
        qd, qdd = (np.outer(values, travel) for values in (speed, push))
        qd[[0, -1]] = qdd[-1] = 0.0
        return TrajectorySamples(
            period_s=period_s,
            t_s=t,
            q_m=np.array([0.3, 0.0, 2.1, 1.09, 1.25]) + np.outer(rise, travel),
            qd_mps=qd,
            qdd_mps2=qdd,
            pose=np.sin(t[:, None] + np.arange(6.0)),
            kappa=20.0 + np.cos(t),
        )

    return make


@pytest.fixture(scope="session")
def reference() -> TrajectorySamples:
    """Read the motion of the reference machine that is kept in the repository: 707 rows, three mode changes."""
    table = read_csv((Path(__file__).parents[2] / "results/reference/agder/trajectory.csv").read_text())

    def stacked(names: Iterable[str]) -> np.ndarray:
        return np.stack([table[name] for name in names], axis=1)

    q, qd, qdd, pose = (stacked(names) for names in (POSITIONS, VELOCITIES, ACCELERATIONS, POSE))
    return TrajectorySamples(float(table["t_s"][1]), table["t_s"], q, qd, qdd, pose, table["kappa"])
