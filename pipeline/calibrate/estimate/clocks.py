"""First estimates of clock offsets: those with which reflectors were seen most nearly where the plan has them.

The tracker's frame is not known, so that for every offset that is tried the frame is fitted, robustly, to the motion.
"""

import numpy as np
from scipy.interpolate import CubicSpline

from pipeline.arrays import FloatArray
from pipeline.calibrate.data.poses import StaticPoses
from pipeline.calibrate.data.reading import MOST_LATE_S
from pipeline.calibrate.estimate.frame import fit_frame_robustly
from pipeline.calibrate.model.forward import close, positions
from pipeline.calibrate.model.model import Model

_STEPS_S = (0.05, 0.005)
_TABLE_S = 0.01
_MOST_ROWS = 200


def first_clocks(model: Model, poses: StaticPoses) -> FloatArray:
    """Estimate the clock offset of every motion, to a few milliseconds. Shape (motions,)."""
    if poses.timing is None:
        return np.zeros(0)
    planned = _planned_points(model, poses)
    return np.array([_first_clock(planned, poses, motion) for motion in range(poses.motions)])


def planned_poses(model: Model, poses: StaticPoses) -> FloatArray:
    """Give the planned poses at all rows of motions, with the clock offsets of a model. Shape (moving, 6)."""
    assert poses.timing is not None, "only motions are planned"
    return poses.timing.driven.pose(poses.times_s(model.clocks_s))


def _planned_points(model: Model, poses: StaticPoses) -> CubicSpline:
    """Give reflectors (reflectors, 3) in the machine's frame over the time of the controller."""
    assert poses.timing is not None, "only motions are planned"
    driven = poses.timing.driven
    t = np.arange(0.0, driven.trajectory.duration_s + _TABLE_S, _TABLE_S)
    own = model.with_frame(np.eye(3), np.zeros(3))
    return CubicSpline(t, positions(own, close(own, driven.encoders(t), driven.pose(t))))


def _first_clock(planned: CubicSpline, poses: StaticPoses, motion: int) -> float:
    assert poses.timing is not None, "only motions have clocks"
    rows = np.flatnonzero((poses.timing.motion == motion) & poses.is_seen.any(axis=1))
    rows = rows[:: -(-len(rows) // _MOST_ROWS)]
    t, seen = poses.timing.t_s[rows], poses.is_seen[rows]
    found, reach = 0.0, MOST_LATE_S
    for step in _STEPS_S:
        tried = found + np.arange(-reach, reach + step / 2.0, step)
        off = [_misfit(planned((t - late).clip(0.0, planned.x[-1]))[seen], poses.seen_m[rows][seen]) for late in tried]
        found, reach = float(tried[np.argmin(off)]), step
    return found


def _misfit(points_m: FloatArray, seen_m: FloatArray) -> float:
    """How far points are off in the median; where they do not move at all, nothing is told of their frame."""
    if np.ptp(points_m, axis=0).max() < 1e-6:
        return np.inf
    return fit_frame_robustly(points_m, seen_m).median_m
