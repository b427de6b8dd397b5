"""Stage two: a smooth curve in actuator space along the route, from programs on a mesh, checked between its nodes."""

from pipeline.refine.coarse import coarse_path
from pipeline.refine.measure import PathFigures, PathSamples, measure_path, sample_path
from pipeline.refine.motion import kappa_along, pose_derivatives, pose_spline
from pipeline.refine.refiner import refine_path
from pipeline.refine.result import Path, Refinement

__all__ = [
    "Path",
    "PathFigures",
    "PathSamples",
    "Refinement",
    "coarse_path",
    "kappa_along",
    "measure_path",
    "pose_derivatives",
    "pose_spline",
    "refine_path",
    "sample_path",
]
