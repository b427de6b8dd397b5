"""The proven error of the tool, for given errors of drives and geometry, and which errors an accuracy asks for."""

from pipeline.pose_error.amplification import DriveAmplification, amplify_drives
from pipeline.pose_error.bound import PoseError, bound_pose_error
from pipeline.pose_error.samples import SampledError, sample_pose_error
from pipeline.pose_error.table import pose_error_columns, pose_error_of
from pipeline.pose_error.tolerances import DriveTolerance, find_drive_tolerances

__all__ = [
    "DriveAmplification",
    "DriveTolerance",
    "PoseError",
    "SampledError",
    "amplify_drives",
    "bound_pose_error",
    "find_drive_tolerances",
    "pose_error_columns",
    "pose_error_of",
    "sample_pose_error",
]
