"""The parts of the report that take longest: they need no more than stages one and two."""

from typing import TYPE_CHECKING

from pipeline.report.coarse import CoarseMotion, drive_coarse
from pipeline.report.data import Picture, Table
from pipeline.report.tables import workspace_part

if TYPE_CHECKING:
    from pipeline.run.results import Results


def coarse_motion(results: "Results") -> CoarseMotion:
    """Drive the coarse path."""
    return drive_coarse(results.config, results.refinement.coarse)


def workspace(results: "Results") -> tuple[Table, Picture]:
    """Tabulate and draw the usable workspace."""
    return workspace_part(results.machine)
