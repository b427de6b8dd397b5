"""Stage three: the path in time, as fast as the actuators' velocity and acceleration limits allow."""

from pipeline.retime.result import Trajectory, TrajectorySamples, stretched
from pipeline.retime.retime import retime_path
from pipeline.retime.sampling import sample
from pipeline.retime.verify import TrajectoryFigures, Usage, measure_trajectory, measure_usage, require_limits

__all__ = [
    "Trajectory",
    "TrajectoryFigures",
    "TrajectorySamples",
    "Usage",
    "measure_trajectory",
    "measure_usage",
    "require_limits",
    "retime_path",
    "sample",
    "stretched",
]
