"""A planned motion corrected for the machine as it really is: in actuator space, so that modes may still change."""

from pipeline.correct.correction import Correction, correct_path
from pipeline.correct.errors import PoseErrors, pose_errors
from pipeline.correct.reach import ReachGap, reach_gaps
from pipeline.correct.verdict import Motion, Verdict, judge, measure_motion

__all__ = [
    "Correction",
    "Motion",
    "PoseErrors",
    "ReachGap",
    "Verdict",
    "correct_path",
    "judge",
    "measure_motion",
    "pose_errors",
    "reach_gaps",
]
