"""Stage three: a path becomes a trajectory, as fast as the limits of actuators, links and TCP allow."""

from pipeline.retime.proof.motion_proof import MotionProof, law_sha256, prove_motion, require_proven
from pipeline.retime.quality.drives import MotionDrives, measure_drives
from pipeline.retime.quality.interpolation import Interpolation, interpolations, safe_to_interpolate
from pipeline.retime.quality.motion_quality import MotionQuality, measure_quality
from pipeline.retime.quantities import QUANTITIES, Quantity
from pipeline.retime.result import TimingReport, Trajectory, TrajectorySamples, slowed, stretched
from pipeline.retime.retime import TimingOptions, retime_path
from pipeline.retime.sampling import sample_at, sample_trajectory, whole_periods
from pipeline.retime.usage import TrajectoryFigures, Usage, measure_trajectory, measure_usage, require_limits
from pipeline.retime.way_back import time_reversed, way_back

__all__ = [
    "QUANTITIES",
    "Interpolation",
    "MotionDrives",
    "MotionProof",
    "MotionQuality",
    "Quantity",
    "TimingOptions",
    "TimingReport",
    "Trajectory",
    "TrajectoryFigures",
    "TrajectorySamples",
    "Usage",
    "interpolations",
    "law_sha256",
    "measure_drives",
    "measure_quality",
    "measure_trajectory",
    "measure_usage",
    "prove_motion",
    "require_limits",
    "require_proven",
    "retime_path",
    "safe_to_interpolate",
    "sample_at",
    "sample_trajectory",
    "slowed",
    "stretched",
    "time_reversed",
    "way_back",
    "whole_periods",
]
