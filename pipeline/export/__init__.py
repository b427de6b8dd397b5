"""Results in the forms other programs read: tables, messages and keyframes for controllers and simulators, and back."""

from pipeline.export.beckhoff import format_beckhoff, read_beckhoff
from pipeline.export.csv import format_csv, read_csv, trajectory_columns
from pipeline.export.linuxcnc import format_halstreamer, read_halstreamer
from pipeline.export.motion import Motion, motion_of, needed_decimals
from pipeline.export.mujoco import format_keyframes, read_keyframes
from pipeline.export.ros2 import format_json, format_yaml, read_joint_trajectory
from pipeline.export.sidecar import sidecar
from pipeline.export.writing import CsvOptions, format_samples

__all__ = [
    "CsvOptions",
    "Motion",
    "format_beckhoff",
    "format_csv",
    "format_halstreamer",
    "format_json",
    "format_keyframes",
    "format_samples",
    "format_yaml",
    "motion_of",
    "needed_decimals",
    "read_beckhoff",
    "read_csv",
    "read_halstreamer",
    "read_joint_trajectory",
    "read_keyframes",
    "sidecar",
    "trajectory_columns",
]
