"""Stage two: a smooth curve in actuator space through the route; a nonlinear program, checked between its nodes."""

from pipeline.refine.coarse import coarse_path
from pipeline.refine.measure import PathFigures, PathSamples, measure, sample_path
from pipeline.refine.refiner import refine_path
from pipeline.refine.result import Path, Refinement

__all__ = [
    "Path",
    "PathFigures",
    "PathSamples",
    "Refinement",
    "coarse_path",
    "measure",
    "refine_path",
    "sample_path",
]
