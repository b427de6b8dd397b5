"""The parts of the report that take longest: they need no more than stages one and two."""

from typing import TYPE_CHECKING

from pipeline.refine.coarse import coarse_path
from pipeline.refine.measure import PathFigures, measure_path
from pipeline.report.coarse import CoarseMotion, drive_coarse
from pipeline.report.data import Picture, Table
from pipeline.report.tables import workspace_part
from pipeline.route.metric import step_sizes

if TYPE_CHECKING:
    from pipeline.run.results import Results


def coarse_motion(results: "Results") -> CoarseMotion:
    """Drive the coarse path, made from the route: it is known before the refined one is."""
    steps = step_sizes(results.config.route)
    return drive_coarse(results.config, coarse_path(results.machine, results.route, steps))


def workspace(results: "Results") -> tuple[Table, Picture]:
    """Tabulate and draw the usable workspace."""
    return workspace_part(results.machine)


def measured_paths(results: "Results") -> tuple[PathFigures, ...]:
    """Measure both paths; their samples keep what that computes."""
    steps = step_sizes(results.config.route)
    return tuple(measure_path(samples, steps) for samples in results.samples)
