"""The reference motion that is kept in git, as a path and as a motion in time."""

from pathlib import Path

import numpy as np
from scipy.interpolate import BSpline

from pipeline.export.csv import read_csv
from pipeline.export.trajectory_columns import POSE, POSITIONS
from pipeline.machine import Machine
from pipeline.refine.result import Path as PlannedPath
from pipeline.refine.splines import DEGREE, clamped_knots, fit

TABLE = Path(__file__).parents[1] / "results" / "reference" / "agder" / "trajectory.csv"


def reference_path(machine: Machine) -> PlannedPath:
    """Fit splines to the reference motion, which changes the mode of every arm; s is its length."""
    table = read_csv(TABLE.read_text())
    q, pose = (np.stack([table[name] for name in names], axis=1) for names in (POSITIONS, POSE))
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1)))
    rows = np.flatnonzero(np.diff(length, prepend=-1.0) > 1e-6)
    s, knots = length[rows] / length[-1], clamped_knots(38)
    return PlannedPath(machine, BSpline(knots, fit(knots, s, q[rows]), DEGREE), s, pose[rows])
