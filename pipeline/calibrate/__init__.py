"""From a tracker's measurements of static poses, and of motions, to the machine as it is, and how sure that is."""

from pipeline.calibrate.calibration import Calibration, Check, Setting, calibrate
from pipeline.calibrate.configuration import calibrated_yaml
from pipeline.calibrate.data.motions import DrivenMotion
from pipeline.calibrate.data.poses import StaticPoses
from pipeline.calibrate.data.reading import read_poses
from pipeline.calibrate.data.simulated import StaticSetting, simulate_motion, simulate_static
from pipeline.calibrate.next_poses import NextPoses, first_poses, next_poses
from pipeline.calibrate.verdict import Verdict, judge

__all__ = [
    "Calibration",
    "Check",
    "DrivenMotion",
    "NextPoses",
    "Setting",
    "StaticPoses",
    "StaticSetting",
    "Verdict",
    "calibrate",
    "calibrated_yaml",
    "first_poses",
    "judge",
    "next_poses",
    "read_poses",
    "simulate_motion",
    "simulate_static",
]
