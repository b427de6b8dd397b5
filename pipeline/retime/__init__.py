"""Stage three: the path in time, as fast as the limits of actuators, links and TCP allow."""

from pipeline.retime.result import Quality, Trajectory, TrajectorySamples, slowed, stretched
from pipeline.retime.retime import retime_path, way_back
from pipeline.retime.reverse import time_reversed
from pipeline.retime.sampling import sample_trajectory, whole_periods
from pipeline.retime.verify import TrajectoryFigures, Usage, measure_trajectory, measure_usage, require_limits

__all__ = [
    "Quality",
    "Trajectory",
    "TrajectoryFigures",
    "TrajectorySamples",
    "Usage",
    "measure_trajectory",
    "measure_usage",
    "require_limits",
    "retime_path",
    "sample_trajectory",
    "slowed",
    "stretched",
    "time_reversed",
    "way_back",
    "whole_periods",
]
